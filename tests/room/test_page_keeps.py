"""What the page keeps, in a real browser: files, links, and its setting when the server comes back."""

import csv
import signal

import pytest

pytest.importorskip("playwright", reason="needs the extra room-test")

from playwright.sync_api import expect

from benchmarks.browser import Room, is_drawn
from drillrig_env.env.recorded import Recorded
from drillrig_env.env.single import DrillRigEnv
from tests.room.looking import type_into

pytestmark = pytest.mark.room


def test_what_is_kept_is_the_environments(page, tmp_path):
    page.select_option("#times", "10")
    page.wait_for_timeout(800)
    type_into(page, "Normal force N₁ N", "16")
    page.get_by_role("button", name="Take over lane A").click()
    page.wait_for_timeout(800)
    page.get_by_role("button", name="Pause").click()
    expect(page.get_by_role("button", name="Go on")).to_be_visible()
    kept = {}
    for name in ("CSV", "Run", "Picture"):
        with page.expect_download() as download:
            page.get_by_role("button", name=name, exact=True).click()
        kept[name] = tmp_path / download.value.suggested_filename
        download.value.save_as(kept[name])
    run = Recorded.read(kept["Run"])
    rows = list(csv.DictReader(kept["CSV"].read_text().splitlines()))
    assert rows[-1]["normal_force [N]"] == "16"
    assert rows[-1]["A_by_hand"] == "1"
    for name in "AB":
        env = DrillRigEnv(**run.environment(name))
        env.reset(**run.reset)
        for row, action in zip(rows, run.actions(name), strict=True):
            env.step(action)
            assert row[f"{name}_bit_speed [rad/s]"] == f"{env.core.episodes['state'][0, 2]:.10g}"
    assert kept["Picture"].read_bytes().startswith(b"\x89PNG")
    page.set_input_files("#replay", kept["Run"])
    expect(page.get_by_label("Normal force N₁ N", exact=True)).to_be_disabled()
    expect(page.get_by_role("button", name="Pause")).to_be_visible()  # it plays, though the clock stood
    bad = tmp_path / "bad.json"
    bad.write_text("{}")
    page.set_input_files("#replay", bad)
    expect(page.locator("#refusal-keep")).to_contain_text("not a recorded run")
    bad.write_text("null")
    page.set_input_files("#replay", bad)
    expect(page.locator("#refusal-keep")).to_contain_text("bad.json is no run that was kept here: it holds no")
    bad.write_text("not JSON")
    page.set_input_files("#replay", bad)
    expect(page.locator("#refusal-keep")).to_contain_text("bad.json is no run")


def test_a_link_holds_the_whole_setting(page, visit, served):
    type_into(page, "Normal force N₁ N", "17.5")
    type_into(page, "Seed", "5")
    page.get_by_label("Controller of lane B", exact=True).select_option("z_torque")
    link = ""
    while not all(
        part in link for part in ("normal_force=17.5", "seed=5", "b=z_torque")
    ):  # once the server has answered
        page.wait_for_timeout(100)
        page.get_by_role("button", name="Link").click()
        link = page.evaluate("() => location.href")
    expect(page.locator("#kept")).not_to_be_empty()
    other = visit(link)
    expect(other.get_by_label("Normal force N₁ N", exact=True)).to_have_value("17.5")
    expect(other.get_by_label("Controller of lane B", exact=True)).to_have_value("z_torque")
    expect(other.get_by_label("Seed", exact=True)).to_have_value("5")
    wrong = visit(f"{served.address}/#normal_force=-3&colour=%3Cimg%20src%3Dx%3E")
    expect(wrong.locator("#refusal-other")).to_contain_text("unknown setting 'colour'")
    expect(wrong.get_by_label("Normal force N₁ N", exact=True)).to_have_value("10")


def test_a_server_that_dies_is_said_and_the_page_comes_back_with_its_setting(visit):
    first = Room(("--port", "0"))
    port = first.address.rpartition(":")[2]
    page = visit(first.address)
    type_into(page, "Normal force N₁ N", "17")
    expect(page.get_by_label("Normal force N₁ N", exact=True)).to_have_value("17")
    first.process.send_signal(signal.SIGSTOP)  # what is asked for now, nobody answers
    page.get_by_label("Controller of lane B", exact=True).select_option("soft_torque")
    first.process.kill()
    first.process.wait()
    expect(page.locator("#connection")).to_contain_text("The server does not answer")
    second = Room(("--port", port))
    try:
        expect(page.locator("#connection")).to_contain_text("a run with the same setting begins anew", timeout=20_000)
        expect(page.locator("#connection")).to_be_hidden(timeout=20_000)
        expect(page.get_by_label("Normal force N₁ N", exact=True)).to_have_value("17")
        expect(page.get_by_label("Controller of lane B", exact=True)).to_have_value("soft_torque")
        is_drawn(page, 0.5)
    finally:
        second.close()
