"""Rigs of all kinds against the stored independent solutions."""

import numpy as np
import pytest

from benchmarks.any_rig import LIMIT, error_of, reference, speed_scale
from tests.reference.any_rig import RIGS, stored

REFERENCE = stored()


@pytest.mark.parametrize("period", [0.1, 0.02])
def test_no_rig_is_off_by_more_than_a_millionth_of_its_speed_scale(period):
    errors = [error_of(case, speeds, period) for case, speeds in REFERENCE]
    assert len(errors) == RIGS
    assert max(errors) <= LIMIT
    assert np.median(errors) < 1e-9


def test_rigs_are_of_all_kinds():
    rigs = [case.rig for case, _ in REFERENCE]
    for name in ("J_2", "d_1", "L", "k_i", "omega_s"):
        values = [getattr(rig, name) for rig in rigs]
        assert max(values) > 50.0 * min(values)
    assert max(np.abs(speeds).max() for _, speeds in REFERENCE) > 200.0
    assert sum(np.abs(speeds[4:, 0]).min() < case.rig.omega_s for case, speeds in REFERENCE) > RIGS // 3


@pytest.mark.slow
def test_stored_solutions_come_out_again():
    for case, speeds in REFERENCE[::10]:
        found = reference(case)
        assert found is not None
        np.testing.assert_allclose(found, speeds, atol=1e-9 * speed_scale(case, speeds))
