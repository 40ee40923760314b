"""The figures of the chapter: files, captions, refusals, and that stable and unstable can be told apart."""

import builtins
import importlib
import sys

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib import rcParams
from matplotlib.text import Text

from drillrig_env import Friction, Rig, simulate
from drillrig_env.plots.__main__ import main
from drillrig_env.plots.figures import FIGURES, draw, write
from drillrig_env.plots.own_rig import pressed
from drillrig_env.stability import critical_speed, fold_speed
from tests.rigs import FAST, FIELD, scaled

QUICK = ("4.1", "4.10")


@pytest.fixture(scope="module")
def pictures():
    return {name: draw(name) for name in FIGURES}


def dashes(line):
    return line.get_linestyle() == "--"


def ends(line):
    return line.get_xdata()[0], line.get_xdata()[-1]


def test_every_figure_of_the_chapter_is_there():
    assert list(FIGURES) == [*(f"4.{number}" for number in range(1, 14)), "bistable", "laws"]


@pytest.mark.parametrize("name", FIGURES)
def test_captions_name_the_figure_and_its_parameters(pictures, name):
    caption = pictures[name].caption
    assert caption.startswith("Beyond the chapter" if name in ("bistable", "laws") else f"Figure {name}. ")
    assert "N_1 = " in caption or "normal force" in caption or " at 10 N" in caption
    below = pictures[name].figure.texts[-1].get_text()
    assert " ".join(below.split()) == " ".join(caption.split())


@pytest.mark.parametrize("name", FIGURES)
def test_print_is_readable_and_axes_are_labelled_with_units(pictures, name):
    figure = pictures[name].figure
    assert figure.get_size_inches()[0] == 6.5
    assert min(text.get_fontsize() for text in figure.findobj(Text) if text.get_text().strip()) >= 8.0
    units = ("rad/s", "N", "N m", "A", "rad", "s", "1/s")
    labels = [label for axes in figure.axes for label in (axes.get_xlabel(), axes.get_ylabel()) if label]
    assert labels
    assert all(label.rsplit(", ", 1)[-1] in units for label in labels)


@pytest.mark.parametrize("name", FIGURES)
def test_captions_stay_inside_the_page(pictures, name):
    figure = pictures[name].figure
    figure.draw_without_rendering()
    page, text = figure.bbox, figure.texts[-1].get_window_extent()
    assert page.x0 < text.x0
    assert text.x1 < page.x1
    assert page.y0 < text.y0
    assert all(axes.get_tightbbox().y0 > text.y1 for axes in figure.axes)


@pytest.mark.parametrize("name", ["4.8", "4.9", "4.10", "4.12", "4.13"])
def test_stable_is_solid_and_unstable_dashed(pictures, name):
    lines = [line for line in pictures[name].figure.axes[0].get_lines() if len(line.get_xdata()) > 10]
    assert any(dashes(line) for line in lines)
    assert any(line.get_linestyle() == "-" for line in lines)


@pytest.mark.parametrize(("name", "force"), [("4.12", 10.0), ("4.13", 20.0)])
def test_branches_of_the_diagrams_meet_at_the_critical_speed_and_the_fold(pictures, name, force):
    border, fold = critical_speed(Rig(), Friction(force)), fold_speed(Rig(), Friction(force))
    axes = pictures[name].figure.axes[0]
    lines = [line for line in axes.get_lines() if len(line.get_xdata()) > 10]
    dashed, solid = [line for line in lines if dashes(line)], [line for line in lines if not dashes(line)]
    assert len(dashed) == 3  # e1, and p2's highest and lowest
    assert len(solid) == 3  # e2, and p1's
    assert ends(dashed[0])[1] == pytest.approx(border) == ends(solid[0])[0]
    for line in dashed[1:]:
        assert ends(line) == (pytest.approx(border, abs=1e-3), pytest.approx(fold, abs=1e-3))
    for line in solid[1:]:
        assert ends(line)[1] == pytest.approx(fold, abs=1e-3)
    words = {text.get_text() for text in axes.texts}
    assert {"$e_1$", "$e_2$", "$p_1$", "$p_2$", "$H_1$", "$H_2$", "fold", "bistable"} <= words


def test_phase_planes_close_and_lie_on_p1(pictures):
    diagram, *planes = pictures["4.12"].figure.axes
    assert len(planes) == 3
    solid = [line for line in diagram.get_lines() if len(line.get_xdata()) > 10 and not dashes(line)]
    p1 = max(solid, key=lambda line: max(line.get_ydata()))
    for axes, speed in zip(planes, (1.0, 1.8, 2.6), strict=True):
        twist, bit_speed = axes.get_lines()[0].get_data()
        assert (twist[0], bit_speed[0]) == (pytest.approx(twist[-1], abs=1e-5), pytest.approx(bit_speed[-1], abs=1e-5))
        assert max(bit_speed) == pytest.approx(np.interp(speed, *p1.get_data()), abs=5e-3)


def test_time_responses_do_what_the_chapter_says(pictures):
    def curve(name, panel):
        axes = pictures[name].figure.axes[panel]
        return max((line.get_data() for line in axes.get_lines()), key=lambda data: len(data[0]))

    _, free = curve("4.2", 0)
    assert free[-1] == pytest.approx(3.14, abs=0.05)  # the free oscillation dies
    time, loaded = curve("4.6", 0)
    assert loaded[(time > 40) & (time < 46)].min() < 1e-3  # stick-slip while the pin presses
    assert np.ptp(loaded[time > 68]) < 0.2  # and none after it
    time, current = curve("4.7", 1)
    assert np.ptp(current[time < 50]) < 1e-6 < 0.5 < np.ptp(current[time > 60])
    time, slow = curve("4.11", 1)
    assert slow[time > 90].min() < 1e-3
    time, fast = curve("4.11", 2)
    assert np.ptp(fast[time > 95]) < 0.1
    whole = simulate(friction=Friction(25.0), speed_reference=3.14, duration=60.0, sample_period=0.005)
    np.testing.assert_array_equal(curve("4.4", 0)[1], whole.bit_speed)


def test_formats_are_written_and_the_same_each_time(tmp_path):
    assert list(write(tmp_path / "one", QUICK)) == list(QUICK)
    assert list(write(tmp_path / "two", QUICK)) == list(QUICK)
    files = sorted(path.name for path in (tmp_path / "one").iterdir())
    assert files == ["4.1.png", "4.1.svg", "4.10.png", "4.10.svg", "captions.md"]
    for file in files:
        assert (tmp_path / "one" / file).read_bytes() == (tmp_path / "two" / file).read_bytes()


def test_captions_of_earlier_figures_stay_in_order(tmp_path):
    list(write(tmp_path, ["4.10"], ["svg"]))
    list(write(tmp_path, ["4.1"], ["svg"]))
    text = (tmp_path / "captions.md").read_text(encoding="utf-8")
    assert text.index("\n## 4.1\n") < text.index("\n## 4.10\n")
    assert text.count("![") == 2
    assert draw("4.10").caption in text


def test_drawing_leaves_the_settings_of_matplotlib_and_no_open_figures():
    before, open_before = dict(rcParams), plt.get_fignums()
    draw("4.1")
    assert dict(rcParams) == before
    assert plt.get_fignums() == open_before


def test_unknown_names_and_formats_are_refused(tmp_path):
    with pytest.raises(ValueError, match=r"did you mean 4\.12\?"):
        draw("fig4.12")
    with pytest.raises(ValueError, match="format 'svgz' is not known; did you mean svg"):
        list(write(tmp_path, QUICK, ["svgz"]))


def test_command_line_draws_what_is_asked_for(tmp_path, capsys):
    assert main(["--only", "4.1", "4.1", "--format", "svg", "--output", str(tmp_path)]) == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["4.1.svg", "captions.md"]
    assert capsys.readouterr().out.strip().endswith(str(tmp_path))


def test_command_line_refuses_a_wrong_name_before_it_draws(tmp_path, capsys):
    with pytest.raises(SystemExit) as refusal:
        main(["--only", "4.1", "bistabel", "--output", str(tmp_path / "figures")])
    assert refusal.value.code == 2
    assert "did you mean bistable?" in capsys.readouterr().err
    assert not (tmp_path / "figures").exists()


def test_interruption_keeps_what_is_written(tmp_path, capsys, monkeypatch):
    def interrupt(rig):
        raise KeyboardInterrupt

    monkeypatch.setitem(FIGURES, "4.10", interrupt)
    assert main(["--only", "4.1", "4.10", "--format", "png", "--output", str(tmp_path)]) == 130
    assert sorted(path.name for path in tmp_path.iterdir()) == ["4.1.png", "captions.md"]
    assert "stopped by Ctrl-C; written so far: 4.1" in capsys.readouterr().err


def without(monkeypatch, package):
    original = builtins.__import__

    def refuse(name, *arguments, **keywords):
        if name.split(".")[0] == package:
            raise ImportError(name)
        return original(name, *arguments, **keywords)

    monkeypatch.setattr(builtins, "__import__", refuse)


def test_missing_matplotlib_says_what_to_install(monkeypatch):
    style = sys.modules["drillrig_env.plots.style"]
    monkeypatch.delitem(sys.modules, "drillrig_env.plots.style")
    without(monkeypatch, "matplotlib")
    with pytest.raises(ImportError, match=r"pip install -e '\.\[plot\]'"):
        importlib.import_module(style.__name__)


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if name in QUICK else pytest.mark.slow) for name in FIGURES]
)
def test_every_figure_is_drawn_for_a_rig_of_ones_own_and_says_in_what_it_differs(pictures, name):
    own, chapter = draw(name, Rig(k_1=0.9, J_1=0.04)), pictures[name]
    assert "For a rig with J_1 = 0.04 kg m^2, k_1 = 0.9 N m/rad: " in own.caption
    assert "For a rig" not in chapter.caption
    assert "the chapter prints" not in own.caption


def test_the_fold_in_a_caption_is_that_of_the_rig():
    rig = Rig(k_1=0.9, J_1=0.04)
    fold = float(fold_speed(rig, pressed(rig, 10.0)))
    assert f"{fold:.3f} rad/s" in draw("4.12", {"k_1": 0.9, "J_1": 0.04}).caption


def test_a_rig_without_stick_slip_has_the_figures_that_it_can_have(tmp_path, capsys):
    Rig(d_1=1.0, d_2=1.0).to_toml(tmp_path / "weak.toml")
    arguments = ["--only", "4.1", "4.12", "--format", "svg", "--output", str(tmp_path / "own")]
    assert main([*arguments, "--rig", str(tmp_path / "weak.toml")]) == 1
    said = capsys.readouterr()
    assert "figure 4.12 is left out: this rig has no stick-slip at 10 N" in said.err
    assert said.out.startswith("4.1 and captions.md")
    assert not (tmp_path / "own" / "4.12.svg").exists()


def test_a_rig_file_that_is_wrong_is_named_before_anything_is_drawn(tmp_path, capsys):
    (tmp_path / "rig.toml").write_text("[rig]\nbase = 'chapter'\nk1 = 0.9\n")
    with pytest.raises(SystemExit) as refusal:
        main(["--rig", str(tmp_path / "rig.toml"), "--output", str(tmp_path / "own")])
    assert refusal.value.code == 2
    assert "unknown key k1 = 0.9; did you mean k_1?" in capsys.readouterr().err
    assert not (tmp_path / "own").exists()


@pytest.mark.slow
@pytest.mark.parametrize("rig", [FAST, FIELD])
def test_every_figure_is_drawn_for_rigs_of_other_sizes(rig, tmp_path):
    assert list(write(tmp_path, formats=["png"], rig=rig)) == list(FIGURES)


def test_figures_of_a_scaled_rig_say_the_scaled_numbers():
    caption = draw("4.4", scaled(time=0.5, torque=4.0)).caption
    assert "ω_ref = 6.28 rad/s" in caption
    assert "N_1 = 25 N" in caption  # on a pin that presses at four times the radius
