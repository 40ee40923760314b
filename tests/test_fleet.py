"""Fleets by themselves: how rigs are drawn, what is left out, what is refused."""

import pickle
from dataclasses import asdict, fields, replace

import numpy as np
import pytest

from drillrig_env import Rig
from drillrig_env.fleet import GROUPS, Fleet
from drillrig_env.model import jacobian

SPREAD = {"string": 2.0, "inertias": 1.5, "motor": 1.1, "friction": 3.0}


def test_every_parameter_has_a_factor_of_its_own_within_its_spread():
    members = Fleet.around(spread=SPREAD, count=400, seed=3).members()
    for group, factor in SPREAD.items():
        drawn = (
            np.log(members.friction)
            if group == "friction"
            else np.log([[getattr(rig, name) / getattr(Rig(), name) for name in GROUPS[group]] for rig in members.rigs])
        )
        assert np.abs(drawn).max() <= np.log(factor) * (1 + 1e-12)
        # Uniform on a scale of logarithms: mean 0 and deviation log(f) / sqrt(3), within 5 standard errors.
        assert np.abs(drawn.mean(0)).max() < 5 * np.log(factor) / np.sqrt(3 * 400)
        assert np.allclose(drawn.std(0), np.log(factor) / np.sqrt(3), rtol=0.12)
        correlation = np.corrcoef(drawn.T) - np.eye(drawn.shape[1])
        assert np.abs(correlation).max() < 0.25
    kept = {item.name for item in fields(Rig)} - set(GROUPS["string"]) - set(GROUPS["inertias"]) - set(GROUPS["motor"])
    assert all(getattr(rig, name) == getattr(Rig(), name) for rig in members.rigs for name in kept)


def test_draws_of_a_parameter_do_not_hang_on_the_others_or_on_how_many_there_are():
    few, many = Fleet.around(spread={"k_1": 2.0}, count=5), Fleet.around(spread=SPREAD | {"k_1": 2.0}, count=50)
    assert [rig.k_1 for rig in few.members().rigs] == [rig.k_1 for rig in many.members().rigs[:5]]
    other = Fleet.around(spread={"k_1": 2.0}, count=5, seed=1).members().rigs
    assert not {rig.k_1 for rig in other} & {rig.k_1 for rig in few.members().rigs}


def test_a_parameter_named_by_itself_goes_before_its_group():
    spread = Fleet.around(spread={"k_2": 1.2, "string": 2.0}).spread
    assert spread == {"k_1": 2.0, "k_2": 1.2, "d_1": 2.0, "d_2": 2.0}


def test_rigs_without_a_stable_drive_are_left_out_and_counted():
    rig = Rig(k_i=1200.0)  # close to the integral gain at which the drive shakes by itself
    members = Fleet.around(rig, spread={"inertias": 2.0, "motor": 1.5}, count=100).members(rig)
    assert members.left_out > 5
    assert len(members) == 100
    assert all(np.linalg.eigvals(jacobian(each)).real.max() < 0.0 for each in members.rigs)
    with pytest.raises(ValueError, match="of 200 draws 0 turn steadily"):
        Fleet.around(spread={"d_1": 1.1}, count=2).members(Rig(k_i=1e4))
    with pytest.raises(ValueError, match="rig 1 does not turn steadily"):
        Fleet.of([rig, replace(rig, L=0.01)]).members(rig)


def test_the_drive_is_the_nominal_one_on_every_rig():
    nominal = Rig(k_p=2.5, k_i=0.8)
    for fleet in (Fleet.of([Rig(k_p=7.0), Rig(k_i=3.0)]), Fleet.around(Rig(k_p=9.0), spread={"J_1": 1.3}, count=4)):
        assert {(rig.k_p, rig.k_i) for rig in fleet.members(nominal).rigs} == {(2.5, 0.8)}


def test_a_fleet_goes_through_dictionaries_and_pickle():
    for fleet in (Fleet.around(spread=SPREAD, count=7), Fleet.around(Rig(J_1=0.03), spread={"v_b": 2}, seed=4)):
        assert Fleet.of(asdict(fleet)) == fleet == pickle.loads(pickle.dumps(fleet))
    rigs = Fleet.of([Rig(), replace(Rig(), J_1=0.02), {"k_2": 0.4}])
    assert Fleet.of(asdict(rigs)) == rigs
    assert rigs.rigs[2].k_2 == 0.4
    assert Fleet.of(None) is None


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"spread": {"strings": 2.0}}, "unknown parameter 'strings'; did you mean string"),
        ({"spread": {"k_p": 2.0}}, "k_p is a setting of the drive"),
        ({"spread": {"string": 0.5}}, "string = 0.5 is not allowed; allowed: >= 1"),
        ({"spread": {"string": "2"}}, "string = '2' is text"),
        ({"spread": [1, 2]}, "a dictionary of factors by name"),
        ({"spread": {"k_1": 2.0}, "count": 0}, "count = 0"),
        ({"spread": {"k_1": 2.0}, "seed": -1}, "seed = -1"),
        ({"spread": {"k_1": 2.0}, "seeds": 1}, "unknown field 'seeds'; did you mean seed"),
        ({}, "neither rigs nor a spread"),
        ({"rigs": [{}], "spread": {"k_1": 2.0}}, "both rigs and a spread"),
        ({"rigs": [{"J_1": -1.0}]}, "J_1 = -1.0 kg m\\^2"),
        ("field", "a Fleet, a list of rigs"),
        (3, "a Fleet, a list of rigs"),
    ],
)
def test_what_is_no_fleet_is_refused(given, words):
    with pytest.raises(ValueError, match=words):
        Fleet.of(given)
