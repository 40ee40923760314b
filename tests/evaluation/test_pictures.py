"""What the pictures show: every policy, its numbers, and the physics' own borders."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from matplotlib.text import Text

from drillrig_env import Friction, Rig
from drillrig_env.evaluation.histories import worth_showing
from drillrig_env.evaluation.pictures import draw, draw_all, plot_calming, plot_histories, plot_map, plot_scores
from drillrig_env.stability import critical_speed, fold_speed


def words(picture):
    return [text.get_text() for text in picture.figure.findobj(Text)]


@pytest.mark.parametrize("plot", [plot_calming, plot_map, plot_scores])
def test_pictures_name_every_policy_and_mark_who_is_privileged(comparison, plot):
    results, _ = comparison
    picture = plot(results, "default")
    text = " ".join(words(picture))
    for name in ("constant", "privileged *", "seeds *"):
        assert name in text
    assert "24 rigs" in picture.caption
    assert "DrillRig-v0" in picture.caption


def test_map_has_the_rigs_of_each_policy_and_both_borders(comparison):
    results, _ = comparison
    panels = [panel for panel in plot_map(results, "default").figure.axes if panel.get_visible()]
    assert len(panels) == 3
    for panel in panels:
        *outcomes, critical, fold = panel.get_lines()
        assert sum(len(line.get_xdata()) for line in outcomes) == 24
        assert len({line.get_marker() for line in outcomes}) == 3
        force = critical.get_ydata()[100]
        assert critical.get_xdata()[100] == pytest.approx(critical_speed(Rig(), Friction(force)))
        assert fold.get_xdata()[100] == pytest.approx(fold_speed(Rig(), Friction(force)))


def test_map_names_its_axes_under_the_last_panel_of_every_column(comparison):
    """Also where the last line of panels is not full: four policies in three columns."""
    results, _ = comparison
    scores = dict(results.scores["default"])
    more = replace(results, scores={"default": {**scores, "another": next(iter(scores.values()))}})
    panels = [panel for panel in plot_map(more, "default").figure.axes if panel.get_visible()]
    named = [panel for panel in panels if panel.get_xlabel()]
    assert len(panels) == 4
    assert len({round(panel.get_position().x0, 3) for panel in named}) == len(named) == 3


def test_calming_ends_at_the_share_that_calms_down(comparison):
    results, _ = comparison
    scores = results.scores["default"]
    (panel,) = plot_calming(results, "default").figure.axes
    ends = sorted(line.get_ydata()[-1] for line in panel.get_lines())
    assert ends == pytest.approx(sorted(np.mean(one["time_to_calm"] < 60.0) for one in scores.values()))
    for line in panel.get_lines():
        assert np.all(np.diff(line.get_ydata()) >= 0.0)


def test_labels_of_lines_that_end_together_stay_apart(comparison):
    results, _ = comparison
    (panel,) = plot_calming(results, "degraded").figure.axes
    heights = sorted(text.xyann[1] for text in panel.texts)
    assert np.min(np.diff(heights)) > 0.04


def test_histories_show_bit_speed_reference_and_torque_of_one_rig(comparison):
    results, histories = comparison
    picture = plot_histories(results, histories, "load", "below")
    speeds, torques = picture.figure.axes[:3], picture.figure.axes[3:]
    assert [panel.get_ylabel() for panel in (speeds[0], torques[0])] == ["speed, rad/s", "string torque, N m"]
    kept = histories.of("load", "below")["constant"]
    np.testing.assert_array_equal(speeds[0].get_lines()[0].get_ydata(), kept["average"])
    np.testing.assert_array_equal(torques[0].get_lines()[0].get_ydata(), kept["torque_into_string"])
    assert speeds[0].get_ylim()[1] > kept["highest"].max()
    assert "ω_c = " in picture.caption


def test_a_fold_that_is_not_known_is_left_out_of_the_caption(comparison):
    results, histories = comparison
    for known in (True, False):
        scores = {
            policy: {**columns, "fold": columns["fold"] if known else np.full_like(columns["fold"], np.nan)}
            for policy, columns in results.scores["load"].items()
        }
        caption = plot_histories(replace(results, scores={"load": scores}), histories, "load", "below").caption
        assert ("fold = " in caption) is known
        assert "nan" not in caption


def test_at_most_four_histories_are_worth_showing_action_zero_and_the_best(comparison):
    results, histories = comparison
    scores = results.scores["default"]
    assert worth_showing(scores, histories.of("default", "below"))[0] == "constant"
    many = {f"{name}{i}": one for i in range(3) for name, one in scores.items()}
    assert len(worth_showing(many, many)) == 4


def test_the_same_picture_twice_is_the_same_file(comparison, tmp_path):
    results, histories = comparison
    (first,) = draw(partial(plot_calming, results, "default"), tmp_path / "a", "calming")
    (second,) = draw_all(results, histories, tmp_path / "b", {"calming_default"}, "x_")
    assert second.name == "x_calming_default.png"
    assert first.read_bytes() == second.read_bytes()
