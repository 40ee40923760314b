"""Tables as text, and what the columns stand for."""

import numpy as np
import pytest

from drillrig_env.evaluation.report import cell, difference_rows, grouped, markdown_table, print_suite, rows
from drillrig_env.evaluation.statistics import Estimate
from drillrig_env.evaluation.tables import DIFFERENCES, HARDNESS, MAIN, OTHERS, TABLES, differences


def test_table_marks_who_is_privileged(comparison, capsys):
    results, _ = comparison
    scores = results.scores["default"]
    table = markdown_table(MAIN, rows(scores), results.marks)
    assert "| privileged * |" in table
    assert "| constant |" in table
    assert f"{scores['constant']['mitigated'].mean():.3f}" in table
    print_suite("title", scores, results.marks, "constant", details=True)
    assert "privileged *" in capsys.readouterr().out


def test_who_is_told_and_who_sets_the_drive_stand_apart(comparison, capsys):
    results, _ = comparison
    one = results.scores["default"]["constant"]
    names, marks = ("told", "plain", "soft", "both", "other"), {"told": "*", "soft": "°", "both": "*°"}
    groups = grouped(names, marks)
    assert list(groups.values()) == [["plain", "other"], ["soft"], ["told", "both"]]
    lines = markdown_table(MAIN, rows(dict.fromkeys(names, one)), marks).splitlines()
    first = [line.split("|")[1].strip() for line in lines[2:]]
    assert first == [
        "plain",
        "other",
        "*with the drive's gains*",
        "soft °",
        f"*{list(groups)[2]}*",
        "told *",
        "both *°",
    ]
    assert {line.count("|") for line in lines} == {lines[0].count("|")}
    print_suite("title", dict.fromkeys(names, one), marks, "plain")
    shown = capsys.readouterr().out
    assert shown.index("other") < shown.index("soft °") < shown.index("told *")
    assert list(grouped(["a"], {})) == [""]


def test_terminal_stays_within_80_columns_and_cuts_nothing(comparison, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    results, _ = comparison
    scores = results.scores["default"]
    named = {"jump_ease_estimated": scores["privileged"], "feed_forward_start": scores["privileged"], **scores}
    print_suite("title", named, {"feed_forward_start": "*"}, "constant", details=True)
    out = capsys.readouterr().out
    assert max(map(len, out.splitlines())) <= 80
    assert "…" not in out
    assert "feed_forward_start *" in out


def test_regions_and_bins_divide_the_rigs(comparison):
    results, _ = comparison
    row = rows(results.scores["default"])["constant"]
    assert sum(row[heading].count for heading in ("below ω_c", "bistable", "above")) == row["mitigated"].count == 24
    assert sum(one.count for one in rows(results.scores["default"], HARDNESS)["constant"].values()) == 24


def test_seeds_are_pooled_as_interquartile_mean(comparison):
    results, _ = comparison
    scores = results.scores["default"]["seeds"]
    by_seed = [scores["cost"][scores["seed"] == seed].mean() for seed in ("0", "1", "2")]
    found = MAIN.columns[4].estimate(scores)
    assert found.count == 72
    assert differences(scores, scores)["cost"].value == pytest.approx(0.0, abs=0.5)
    costs = rows({"seeds": scores}, DIFFERENCES)["seeds"]["cost"]
    assert costs.value == pytest.approx(np.mean(by_seed))  # a quarter of three seeds is none
    assert min(by_seed) <= costs.low <= costs.high <= max(by_seed)


def test_differences_are_those_of_the_means_on_the_same_rigs(comparison):
    results, _ = comparison
    scores = results.scores["load"]
    row = difference_rows(scores, "constant")["privileged"]
    for name, score in (("cost", "cost"), ("mitigated", "mitigated"), ("to calm", "time_to_calm")):
        assert row[name].value == pytest.approx(scores["privileged"][score].mean() - scores["constant"][score].mean())
    assert difference_rows(scores, "nobody") == {}


def test_cells():
    assert cell(Estimate(0.5, 0.4, 0.61, 9), 3) == ("0.500", "0.40-0.61")
    assert cell(Estimate(-0.5, -0.6, 0.1, 9), 2, signed=True) == ("-0.50", "-0.6 +0.1")
    assert cell(Estimate(60.0, 60.0, 60.0, 9), 1) == ("60.0", "")
    assert cell(Estimate(np.nan, np.nan, np.nan, 0), 3) == ("none", "")


def test_the_interval_that_is_shown_holds_the_value_that_is_shown():
    assert cell(Estimate(0.999, 0.998, 0.9995, 9), 3) == ("0.999", "0.99-1.00")
    assert cell(Estimate(0.049, 0.0482, 0.0499, 9), 3) == ("0.049", "0.04-0.05")
    assert cell(Estimate(-0.004, -0.0044, -0.0036, 9), 3, signed=True) == ("-0.004", "-0.01 -0.00")
    random = np.random.default_rng(0)
    for low, value, high in np.sort(random.normal(0.0, 1.0, (500, 3))):
        for digits in (1, 2, 3):
            text, interval = cell(Estimate(value, low, high, 9), digits, signed=True)
            ends = [float(end) for end in interval.split()]
            assert ends[0] <= float(text) <= ends[1]
            assert ends == pytest.approx([low, high], abs=0.1 ** max(digits - 1, 1))


def test_an_end_of_an_interval_that_has_the_digits_shown_stays_as_it_is():
    """0.29 times 100 is 28.999999999999996, and 0.1 + 0.2 is 0.30000000000000004."""
    assert cell(Estimate(0.295, 0.29, 0.1 + 0.2, 9), 3) == ("0.295", "0.29-0.30")


def shown(table):
    """The cells of a row whose estimates are all 1.23456, from 1 to 2."""
    row = dict.fromkeys(table.headings, Estimate(1.23456, 1.0, 2.0, 9))
    line = markdown_table(table, {"x": row}, {}).splitlines()[-1]
    return dict(zip(table.headings, (cell.split()[0] for cell in line.strip("| ").split(" | ")[1:]), strict=True))


def test_shares_are_shown_in_thousandths_times_in_control_steps_and_peaks_in_hundredths():
    assert shown(MAIN) == {**dict.fromkeys(MAIN.headings, "1.235"), "to calm": "1.2"}
    assert shown(HARDNESS) == dict.fromkeys(HARDNESS.headings, "1.235")
    assert shown(OTHERS) == {
        **dict.fromkeys(("cost", "stuck", "SSI"), "1.235"),
        "peak ω": "1.23",
        "peak T": "1.23",
        "travel": "1.2",
    }


def test_differences_alone_show_their_sign():
    assert shown(DIFFERENCES) == {**dict.fromkeys(DIFFERENCES.headings, "+1.235"), "to calm": "+1.2"}
    for table in TABLES.values():
        assert not any(cell.startswith("+") for cell in shown(table).values())
