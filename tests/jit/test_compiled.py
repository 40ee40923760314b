import os
import subprocess
import sys
from pathlib import Path
from shutil import copytree

import numpy as np
import pytest

import drillrig_env
from drillrig_env.jit.compiled import bound, compiled

SCRIPT = """
import numpy as np
from drillrig_env.friction import Friction
from drillrig_env.rig import Rig
print(float(Friction(10.0).torque(Rig(), np.array(2.0))))
"""


@pytest.mark.slow
@pytest.mark.parametrize(("edited", "renewed"), [("arrays.py", True), ("evaluation/report.py", False)])
def test_edit_renews_the_kernels_that_stand_on_the_file(tmp_path, edited, renewed):
    package = tmp_path / "drillrig_env"
    copytree(Path(drillrig_env.__file__).parent, package)
    environment = {**os.environ, "PYTHONPATH": str(tmp_path), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}

    def torque():
        command = [sys.executable, "-c", SCRIPT]
        return float(
            subprocess.run(command, env=environment, cwd=tmp_path, capture_output=True, check=True, text=True).stdout
        )

    assert torque() == torque()
    kernels = tmp_path.glob("cache/**/*.nbi")
    stamps = {path: path.stat().st_mtime_ns for path in kernels}
    assert stamps
    (package / edited).write_text((package / edited).read_text() + "\n# edited\n")
    torque()
    assert {path.stat().st_mtime_ns > stamp for path, stamp in stamps.items()} == {renewed}


def double(values):
    values *= 2.0


def test_bound_kernel_works_on_its_arrays_at_each_call():
    values = np.ones(3)
    call = bound(compiled(double), values)
    call()
    values += 1.0
    call()
    np.testing.assert_array_equal(values, 6.0)


def test_without_compilation_one_sentence_says_that_it_cannot_run():
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    command = [sys.executable, "-c", "import drillrig_env; drillrig_env.simulate(duration=1.0)"]
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert done.stderr.splitlines()[-1].startswith("ImportError: NUMBA_DISABLE_JIT is set, and drillrig_env cannot")
