"""The dry run says what became of rigs, and how punctual the loop was."""

import pytest

from drillrig_env.twin.dry_run import main


def test_a_dry_run_tells_of_its_rigs(capsys):
    pytest.importorskip("onnxruntime")
    assert main(["z_torque", "--rigs", "2", "--steps", "40"]) == 0
    assert "of 2 rigs calm at the end; events: none" in capsys.readouterr().out
    assert main(["z_torque", "--real", "--steps", "3"]) == 0
    assert "3 control steps, 0 missed" in capsys.readouterr().out
    with pytest.raises(SystemExit):
        main(["z_torq"])
    assert "did you mean z_torque?" in capsys.readouterr().err
