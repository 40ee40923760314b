"""The pictures of a calibration: that they show what they are of, with names and units."""

from dataclasses import replace

import numpy as np
import pytest

from drillrig_env.calibrate import borders as module
from drillrig_env.calibrate.pictures import draw_all
from drillrig_env.calibrate.pictures.borders import draw_borders
from drillrig_env.calibrate.report import Report
from tests.calibrate.test_calibration import fitted


@pytest.fixture(scope="module")
def report():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "_end", lambda *given: 1.5 * module._critical(*given))
        return Report.of(fitted(), "line", draws=16)


@pytest.fixture(scope="module")
def pictures(report):
    return draw_all(report)


@pytest.mark.slow
def test_there_is_one_of_each_kind_and_of_each_record(pictures):
    assert list(pictures) == ["borders", "intervals", "correlations", "record_1", "record_2"]


def test_a_record_is_shown_with_its_residuals_and_bands(pictures, report):
    picture = pictures["record_1"]
    axes = picture.figure.axes
    assert [one.get_ylabel() for one in axes] == [
        *("bit speed,\nrad/s", "residual\n/ noise", "top speed,\nrad/s", "residual\n/ noise"),
        *("current,\nA", "residual\n/ noise", "voltage,\nV", "residual\n/ noise"),
    ]
    assert axes[-1].get_xlabel() == "time, s"
    legend = {text.get_text() for text in axes[0].get_legend().get_texts()}
    assert legend == {"measured", "model", "rigs drawn", "held out"}
    assert "Shaded windows were held out" in picture.caption
    residuals = np.concatenate([line.get_ydata() for line in axes[1].lines[:-1]])  # the last is the zero
    assert np.nanstd(residuals) == pytest.approx(1.0, abs=0.2)
    band, model = axes[0].collections[0].get_paths()[0].vertices, axes[0].lines[1].get_ydata()
    assert band[:, 1].min() < model.min() + 0.1
    assert np.ptp(band[:, 1]) == pytest.approx(np.ptp(model), rel=0.05)


def test_borders_have_bands(pictures, report):
    axes = pictures["borders"].figure.axes[0]
    critical, end = axes.lines
    np.testing.assert_array_equal(critical.get_xdata(), report.borders.best[0])
    np.testing.assert_array_equal(end.get_xdata(), report.borders.best[1])
    assert axes.get_xlabel().endswith("rad/s")
    assert axes.get_ylabel().endswith(", N")
    assert "5 to 95 % of 16 rigs" in pictures["borders"].caption


def test_borders_are_drawn_where_hardly_any_is_known(report):
    nothing = np.full_like(report.borders.best, np.nan)
    for best in (nothing, np.zeros_like(nothing), np.full_like(nothing, np.inf)):
        borders = replace(report.borders, best=best, draws=np.tile(best, (16, 1, 1)))
        figure = draw_borders(replace(report, borders=borders)).figure
        assert figure.axes[0].get_xlim()[1] > 0.0
        figure.draw_without_rendering()


def test_correlations_are_those_of_the_draws(pictures):
    calibration = fitted()
    table = pictures["correlations"].figure.axes[0].images[0].get_array()
    drawn = np.corrcoef(calibration.draws.T)
    below = np.tril_indices(len(drawn), -1)
    np.testing.assert_allclose(table[below], drawn[below], atol=0.35)
    assert table.mask[np.triu_indices(len(drawn))].all()


def test_intervals_are_beside_what_was_known_beforehand(pictures):
    calibration = fitted()
    axes = pictures["intervals"].figure.axes[0]
    names = [text.get_text() for text in axes.get_yticklabels()]
    assert names == [row[0] for row in calibration.rows()][::-1]
    _, value, _, high, _ = calibration.rows()[-1]
    assert axes.lines[0].get_xdata()[0] == pytest.approx(100.0 * (high / value - 1.0))
