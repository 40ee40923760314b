"""The page's controls in a real browser: by role, name and keyboard, and what they refuse."""

import re

import pytest

pytest.importorskip("playwright", reason="needs the extra room-test")

from playwright.sync_api import expect

from tests.room.looking import lane, seconds, type_into

pytestmark = pytest.mark.room


NAMES = {
    "button": "Pause|Step|Restart|New seed|Lecture|Light or dark|Keys|Take over lane A|Take over lane B|Ramp|CSV|Run|"
    "Picture|Link",
    "combobox": "Speed, times real time|Story|Lanes|Lines over|Controller of lane A|Controller of lane B|Rig|Sensors|"
    "Starts in",
    "slider": "Target speed, slider|Normal force N₁, slider|Static friction μₛ, slider|Kinetic friction μₖ, slider|"
    "Friction decay v_b, slider",
    "textbox": "Target speed rad/s|Normal force N₁ N|Static friction μₛ|Kinetic friction μₖ|Friction decay v_b s/rad|"
    "Noise, of the standard|Delay control steps|Drive k_p V s/rad|Drive k_i V/rad|Seed|to, N|within, s",
    "img": "lane A: the rig as it turns|lane A: speeds, rad/s over time|lane A: torque and current over time|"
    "lane B: reward a control step over time|lane B: operating point on the map of this rig",
    "region": "Lane A|Lane B",
}
"""Names of what must be there, by role."""


UNNAMED = """() => [...document.querySelectorAll('button, input, select, [role=img]')]
    .filter((e) => !(e.getAttribute('aria-label') || e.labels?.length || e.textContent.trim()))
    .map((e) => e.outerHTML.slice(0, 80))"""


def test_every_control_has_a_role_and_a_name(page):
    for role, names in NAMES.items():
        for name in names.split("|"):
            assert page.get_by_role(role, name=name, exact=True).count() >= 1, (role, name)
    assert page.evaluate(UNNAMED) == []


def test_the_clock_stops_steps_and_goes_faster(page):
    page.get_by_role("button", name="Pause").click()
    expect(page.get_by_role("button", name="Go on")).to_be_visible()
    page.wait_for_timeout(300)
    stood = seconds(page)
    page.wait_for_timeout(500)
    assert seconds(page) == stood
    page.get_by_role("button", name="Step", exact=True).first.click()
    expect(page.locator("#time")).to_have_text(f"{stood + 0.1:.1f} s")
    page.select_option("#times", "10")
    page.get_by_role("button", name="Go on").click()
    page.wait_for_timeout(600)
    before = seconds(page)
    page.wait_for_timeout(2000)
    assert 6.0 < seconds(page) - before < 26.0  # 20 s, but for what else the machine does
    page.get_by_role("button", name="Restart").click()
    page.wait_for_function("() => parseFloat(document.getElementById('time').textContent) < 8")
    page.get_by_role("button", name="New seed").click()
    expect(page.get_by_label("Seed", exact=True)).to_have_value("1")


def test_everything_can_be_done_by_keyboard(page):
    page.keyboard.press("Space")
    expect(page.get_by_role("button", name="Go on")).to_be_visible()
    page.wait_for_timeout(300)
    stood = seconds(page)
    page.keyboard.press(".")
    expect(page.locator("#time")).to_have_text(f"{stood + 0.1:.1f} s")
    page.keyboard.press("+")
    expect(page.locator("#times")).to_have_value("2")
    page.keyboard.press("-")
    page.keyboard.press("-")
    expect(page.locator("#times")).to_have_value("0.5")
    page.keyboard.press("a")
    expect(page.get_by_role("button", name="Take over lane A")).to_have_attribute("aria-pressed", "true")
    page.keyboard.press("a")
    expect(page.get_by_role("button", name="Take over lane A")).to_have_attribute("aria-pressed", "false")
    page.keyboard.press("n")
    expect(page.get_by_label("Seed", exact=True)).to_have_value("1")
    slider = page.get_by_role("slider", name="Normal force N₁, slider")
    slider.focus()
    page.keyboard.press("ArrowRight")
    expect(page.get_by_label("Normal force N₁ N", exact=True)).to_have_value("10.1")
    page.keyboard.press("End")
    expect(page.get_by_label("Normal force N₁ N", exact=True)).to_have_value("40")
    page.get_by_label("Seed", exact=True).focus()
    page.keyboard.type("n")  # is typed, and no key of the page's
    expect(page.get_by_label("Seed", exact=True)).to_have_value(re.compile("n"))
    page.get_by_role("combobox", name="Story").focus()
    page.keyboard.type("Past")
    page.keyboard.press("Tab")
    expect(page.get_by_role("heading", name="A rig that sticks at 2.5 rad/s")).to_be_visible()
    page.locator("main").focus()
    page.keyboard.press("]")
    expect(page.get_by_role("heading", name="Faster, past the fold: 3.2 rad/s")).to_be_visible()
    page.keyboard.press("[")
    expect(page.get_by_role("heading", name="A rig that sticks at 2.5 rad/s")).to_be_visible()
    page.keyboard.press("l")
    expect(page.locator("body")).to_have_class(re.compile("lecture"))
    page.keyboard.press("l")
    page.keyboard.press("?")
    expect(page.get_by_role("dialog", name="Keys")).to_be_visible()
    page.get_by_label("single keys do this").uncheck()
    page.keyboard.press("Escape")
    page.locator("main").focus()
    page.keyboard.press("l")
    expect(page.locator("body")).not_to_have_class(re.compile("lecture"))


def test_tab_reaches_every_control(page):
    wanted = page.evaluate("""() => [...document.querySelectorAll('button, input, select, summary')].filter(
        (e) => e.offsetParent !== null && !e.disabled).length""")
    reached = set()
    for _ in range(wanted + 20):
        page.keyboard.press("Tab")
        reached.add(
            page.evaluate("""() => { const all = [...document.querySelectorAll('button, input, select, summary')];
            return all.indexOf(document.activeElement); }""")
        )
    assert len(reached - {-1}) == wanted


def test_the_hand_takes_a_lane_and_gives_it_back(page):
    page.get_by_role("button", name="Take over lane B").click()
    reference = page.get_by_label("Speed reference of lane B, rad/s", exact=True)
    expect(reference).to_be_visible()
    reference.fill("1,5")
    reference.press("Enter")
    expect(reference).to_have_value("1.5")
    page.select_option("#times", "10")
    lane(page, "B").get_by_text("What the controller sees and says").click()
    expect(lane(page, "B").locator(".seen")).to_contain_text(
        re.compile(r"speed reference\s+1\.500 rad/s"), timeout=20_000
    )
    reference.fill("99")
    reference.press("Enter")
    expect(lane(page, "B").get_by_role("alert").filter(has_text="speed_reference = 99 rad/s")).to_be_visible()
    page.get_by_role("button", name="Take over lane B").click()
    expect(reference).to_be_hidden()


BAD = {
    "Target speed rad/s": ["abc", "-1", "0", "1e9", "", "2.5.1", "NaN", "Infinity"],
    "Normal force N₁ N": ["abc", "-5", "", "1e999", "ten", "0x10", "1e300"],
    "Static friction μₛ": ["0.1", "-1", "soft"],
    "Kinetic friction μₖ": ["0.9", "-1", "none"],
    "Friction decay v_b s/rad": ["0", "-2", "x"],
    "Noise, of the standard": ["-1", "loud", "1e9"],
    "Delay control steps": ["11", "-1", "1.5", "late"],
    "Drive k_p V s/rad": ["-1", "x"],
    "Drive k_i V/rad": ["0", "1e5", "x"],
    "Seed": ["-1", "1.5", "luck", "99999999999999999999"],
}


def test_bad_input_in_every_field_is_answered_beside_it_and_changes_nothing(page):
    page.get_by_role("button", name="Pause").click()
    page.wait_for_timeout(300)
    stood = page.locator("#time").inner_text()
    for label, texts in BAD.items():
        field = page.get_by_label(label, exact=True)
        right = field.input_value()
        for text in texts:
            type_into(page, label, text)
            place = page.locator(f"#{field.get_attribute('aria-describedby')}")
            if text == "" and label not in ("Target speed rad/s", "Normal force N₁ N"):
                continue
            expect(place).to_be_visible()
            expect(place).to_contain_text(re.compile("allowed|number|not a message"))
            assert "Traceback" not in place.inner_text()
            expect(field).to_have_attribute("aria-invalid", "true")
            assert field.input_value() == text
        type_into(page, label, right)
        expect(place).to_be_hidden()
    for to, within, words in (
        ("x", "10", "N_1|normal_force"),
        ("-3", "10", "normal_force = -3 N"),
        ("25", "0", "time of a ramp"),
        ("25", "soon", "time of a ramp"),
    ):
        page.get_by_label("to, N", exact=True).fill(to)
        page.get_by_label("within, s", exact=True).fill(within)
        page.get_by_role("button", name="Ramp").click()
        expect(page.locator("#refusal-ramp")).to_contain_text(re.compile(words))
    expect(page.locator("#time")).to_have_text(re.compile(r"^(0\.0 s|" + re.escape(stood) + ")$"))


@pytest.mark.parametrize(
    ("typed", "meant"), [("12,5", "12.5"), ("\uff11\uff12", "12"), (" 7 ", "7"), ("1.5e1", "15"), (".5", "0.5")]
)
def test_numbers_are_read_as_people_write_them(page, typed, meant):
    type_into(page, "Normal force N₁ N", typed)
    expect(page.get_by_label("Normal force N₁ N", exact=True)).to_have_value(meant)


def test_a_controller_that_does_not_see_enough_is_refused_beside_its_name(page):
    page.get_by_label("Controller of lane A", exact=True).select_option("ppo_surface")
    expect(lane(page, "A").locator(".refusal-policy")).to_contain_text(
        re.compile("ppo_surface sees voltage.*sensors that would do: surface")
    )
    expect(page.get_by_label("Controller of lane A", exact=True)).to_have_value("constant")
