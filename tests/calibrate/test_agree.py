"""Records of one rig agree, and of records of different rigs it is told which and in what."""

from dataclasses import replace

import pytest

from drillrig_env import Friction, Rig
from drillrig_env.calibrate.agree import Disagreement, disagreement_words, disagreements
from drillrig_env.calibrate.calibration import calibrate
from tests.calibrate.test_calibration import FIXED, STICKING, UNLOADED, twin

FASTER = replace(twin(3.0, 22.0, 24.0, seed=5), source="faster.csv")
STIFFER = replace(twin(2.2, 20.0, 24.0, seed=6, rig=replace(Rig(), k_2=1.1 * Rig().k_2)), source="stiffer.csv")


def test_records_of_one_rig_agree():
    found = calibrate([STICKING, UNLOADED, FASTER], None, Friction(10.0), fix=FIXED, starts=1)
    assert disagreements(found) == []
    assert disagreement_words([]) == []


@pytest.mark.parametrize(
    "records", [pytest.param([STIFFER, FASTER], marks=pytest.mark.slow), [STICKING, STIFFER, FASTER]]
)
def test_a_record_of_another_rig_is_told_with_its_parameter(records):
    found = disagreements(calibrate(records, None, Friction(10.0), fix=FIXED, starts=1))
    assert found[0].name == "k_2"
    if len(records) == 2:
        assert {found[0].source, found[0].others} == {"stiffer.csv", "faster.csv"}
    else:
        assert (found[0].source, found[0].others) == ("stiffer.csv", "the others")
    stiffer, others = found[0].alone, found[0].beside
    if found[0].source == "faster.csv":
        stiffer, others = others, stiffer
    assert others[0] < 1.002 * Rig().k_2
    assert 0.998 * Rig().k_2 < others[1] < stiffer[0]
    assert stiffer[0] < 1.102 * Rig().k_2
    assert 1.098 * Rig().k_2 < stiffer[1]
    *lines, why = disagreement_words(found)
    assert len(lines) == len(found) <= 3
    assert "may be of different rigs" in why


def test_one_record_is_nothing_to_compare():
    found = calibrate([STICKING], None, Friction(10.0), fix=FIXED, starts=1)
    assert disagreements(found) == []


def test_how_it_is_said():
    one = Disagreement("a.csv", "b.csv", "k_2", (0.39, 0.41), (0.35, 0.37))
    assert str(one) == "a.csv says k_2 = 0.39 to 0.41, b.csv 0.35 to 0.37"
