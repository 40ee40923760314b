"""docs/validation.md says what the code gives, and every printed number comes out."""

from pathlib import Path

import pytest

from docs.make.__main__ import main
from docs.make.validation import COMMAND, page
from drillrig_env.validation import all_checks
from drillrig_env.validation.check import number

PAGE = Path(__file__).parents[1] / "docs" / "validation.md"
DIFFERENT = {
    "the adopted law avoids the discontinuity of (4-7)",
    "J_52 = -k_2/J_3, and Delta T_r,min = -0.0128 N m s/rad",
    "term of x_5 in the balance of disc 2 = -d_2 x_5, and Delta T_r,min = -0.0128 N m s/rad",
    "for omega_ref < omega_min standstill is a stable equilibrium of (4-17)",
    "equilibrium changes its stability at omega_min, at the Hopf point H1",
    "H1 is a supercritical Hopf point",
    "omega_c(20 N) - omega_c(10 N)",
    "right of the curve the system presents no vibration",
}


@pytest.fixture(scope="module")
def checks():
    """Every check. A fixture, so that collecting tests computes nothing."""
    return [check for topic in all_checks().values() for check in topic]


def test_page_is_up_to_date():
    assert PAGE.read_text(encoding="utf-8") == page(), f"docs/validation.md is out of date; run: {COMMAND}"


def test_printed_numbers_come_out_within_their_tolerances(checks):
    numbers = [check for check in checks if check.tolerance is not None]
    assert {check.printed.split()[0] for check in numbers} == {"-0.0128", "1.994", "2.689", "2.9"}
    for check in numbers:
        assert abs(check.difference) <= check.tolerance, f"{check.where}: {check.computed}, printed {check.printed}"
        assert check.agrees


def test_statements_agree_but_for_the_known_disagreements(checks):
    assert {check.statement for check in checks if not check.agrees} == DIFFERENT


def test_every_disagreement_gives_a_reason(checks):
    assert all(check.remark for check in checks if not check.agrees)


def test_cells_do_not_break_the_table(checks):
    assert not any("|" in cell for c in checks for cell in (c.where, c.statement, c.printed, c.computed, c.verdict))


def test_a_number_out_of_tolerance_differs():
    near, far = (number("(1)", "x", 1.0, x, "m", tolerance=0.1, decimals=3) for x in (1.05, 1.2))
    assert near.verdict == "agrees"
    assert far.verdict == "**differs**"
    assert far.difference == pytest.approx(0.2)


def test_command_writes_the_page_and_checks_it(tmp_path, capsys):
    words = ["validation", "--docs", str(tmp_path)]
    assert main([*words, "--check"]) == 1
    assert "out of date: validation; run: python -m docs.make validation" in capsys.readouterr().err
    assert main(words) == 0
    assert (tmp_path / "validation.md").read_text(encoding="utf-8") == page()
    assert main([*words, "--check"]) == 0
    with pytest.raises(SystemExit):
        main(["--help"])
    assert "docs/validation.md" in capsys.readouterr().out
