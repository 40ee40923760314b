"""What tests of the page look for in it."""


def lane(page, name):
    return page.get_by_role("region", name=f"Lane {name}", exact=True)


def seconds(page):
    return float(page.locator("#time").inner_text().split()[0])


def number(place):
    return float(place.inner_text().split()[0].replace("∞", "inf"))


def type_into(page, label, text):
    field = page.get_by_label(label, exact=True)
    field.fill(text)
    field.press("Enter")
    return field
