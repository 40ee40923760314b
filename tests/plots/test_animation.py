"""The command that makes the README's animation."""

import sys

import numpy as np
import pytest

from drillrig_env.plots.animation import Film, frames, main
from tests.rigs import scaled

pytest.importorskip("pygame", reason="the animation needs the extra `render` (pygame-ce)")

SHORT = ["--hold", "1", "--every", "40", "--width", "320"]


def test_the_command_writes_a_gif_that_repeats(tmp_path, capsys):
    pil = pytest.importorskip("PIL.Image", reason="the animation needs Pillow")
    path = tmp_path / "new" / "short.gif"
    main(["--output", str(path), *SHORT])
    with pil.open(path) as picture:
        assert picture.size == (320, 180)
        assert picture.n_frames > 5
        assert picture.info["loop"] == 0
        assert picture.info["duration"] == 2000
    told = capsys.readouterr()
    assert "frames" in told.out
    assert "short.gif: frames done in " in told.err
    assert "\r" not in told.err


def test_the_film_ends_when_the_bit_is_calm_at_the_target():
    film = Film(hold=0.0, every=50)
    seen = list(frames(film))
    assert 2 < len(seen) < 24
    assert all(frame.shape == (540, 960, 3) and frame.dtype == np.uint8 for frame in seen)


def test_the_default_film_runs_at_twice_the_speed_of_the_rig():
    assert Film().frame_time == 50
    assert Film(every=2, speed_up=1).frame_time == 200


def test_impossible_values_end_with_a_message_that_names_them(tmp_path, capsys):
    with pytest.raises(SystemExit):
        main(["--output", str(tmp_path / "none.gif"), "--speed-target", "12"])
    assert "speed_target = 12" in capsys.readouterr().err


def test_a_rig_of_ones_own_is_filmed():
    first = next(iter(frames(Film(every=50))))
    own = next(iter(frames(Film(every=50, rig={"k_1": 0.5}))))
    assert np.any(first != own)
    with pytest.raises(ValueError, match=r"Film: rig: unknown key K_1 = 0\.5; did you mean"):
        Film(rig={"K_1": 0.5})


@pytest.mark.parametrize("value", ["0", "-1"])
@pytest.mark.parametrize("name", ["--every", "--speed-up", "--width"])
def test_a_film_needs_positive_numbers(name, value, tmp_path, capsys):
    with pytest.raises(SystemExit):
        main(["--output", str(tmp_path / "none.gif"), name, value])
    assert "allowed: whole, >= 1" in capsys.readouterr().err


def test_without_pillow_the_error_says_what_to_install(monkeypatch, tmp_path, capsys):
    monkeypatch.setitem(sys.modules, "PIL", None)
    with pytest.raises(SystemExit):
        main(["--output", str(tmp_path / "none.gif"), *SHORT])
    assert "pip install -e '.[render]'" in capsys.readouterr().err


def test_the_help_teaches(capsys):
    with pytest.raises(SystemExit):
        main(["--help"])
    text = capsys.readouterr().out
    assert "drillrig animate --output docs/images/stick_slip.gif" in text
    assert "pip install -e '.[render]'" in text


def test_a_film_of_another_rig_takes_its_own_forces_speeds_and_times():
    film = Film(rig=scaled(time=0.5, torque=4.0))
    assert (film.normal_force, film.speed_target, film.hold) == (20.0, 6.4, 3.0)
    assert Film(rig=film.rig, normal_force=5.0).normal_force == 5.0
    assert (film.frame_time, film.task.duration) == (25, 60.0)
