"""AUTO-07p on the same model: the Hopf point of steady rotation, and the fold of the unstable orbit that begins there.

AUTO gets the model in Fortran, written here, at N_1 = 10 N. It continues steady rotation down from 4 rad/s to the
Hopf point, and from there the unstable orbit p2 to the fold (200 intervals of 4 collocation points), on the law

    T_r1 = N_1 r_1 [mu_k + (mu_s - mu_k) exp(-v_b |x_3|)] s(x_3 / omega_s),    omega_s = 1e-3 rad/s,

with s(z) = z cut off at -1 and 1, which is (4-9) but for its jump of 0.04 % at omega_s, and with two
smooth s(z), whose folds are not that of (4-9): with the kink AUTO does not converge (MX) near the fold.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.measure import median_seconds
from drillrig_env import Friction, Rig
from drillrig_env.model import steady_state

RIG, FRICTION = Rig(), Friction(10.0)
ONE_CORE = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
TIMEOUT = 120.0  # s, for each run of the compiler or of AUTO
START_SPEED = 4.0  # rad/s, where AUTO's equilibria begin
HOPF, FOLD, END = 3, 5, 9  # AUTO's types of points
LIBRARY = Path(os.environ.get("AUTO_DIR", "/usr/lib/auto-07p"), "lib")  # where Debian has AUTO's object files
HINT = "AUTO-07p is not installed and is left out; on Debian: apt-get install auto-07p gfortran"
LAWS = {  # the factor s(z), z = x_3 / omega_s, in Fortran
    "(4-9) without its jump": "sign(min(abs(z), 1d0), z)",
    "s = tanh(z)": "tanh(z)",
    "s = z / (1 + z^8)^(1/8)": "z/(1d0 + z**8)**0.125d0",
}
CONSTANTS = """NDIM=7, NPAR=11, NBC=0, NINT=0, JAC=0, IPLT=0, IID=2, MXBF=0, ILP=1, ISP=2, ISW=1
NCOL=4, IAD=3, IADS=1, ITMX=9, ITNW=7, NWTN=3, NPR=1000, RL0=1.0, RL1=5.0, A0=0.0, A1=1e6, THL={11: 0.0}
"""
EQUILIBRIA = """IPS=1, IRS=0, ICP=[1], NTST=20, NMX=1000, EPSL=1e-10, EPSU=1e-10, EPSS=1e-8
DS=-0.01, DSMIN=1e-6, DSMAX=0.05, STOP=['HB1']
"""
ORBITS = """IPS=2, IRS=2, ICP=[1, 11], NTST=200, NMX=400, EPSL=1e-7, EPSU=1e-7, EPSS=1e-5
DS=0.01, DSMIN=1e-6, DSMAX=0.5, STOP=['LP1']
"""


def is_installed() -> bool:
    """Whether AUTO and the compiler that it needs are here."""
    return (LIBRARY / "main.o").exists() and shutil.which("gfortran") is not None


def fortran(law: str) -> str:
    """The model (4-17) as AUTO wants it, with `law` as the factor s(z); par(1) is the speed reference."""

    def number(value: float) -> str:
        return f"({value:.17e})".replace("e", "d")

    p, f = RIG, FRICTION
    scale = float(np.max(f.normal_force)) * p.r_1
    values = {
        **{name: getattr(p, name) for name in ("J_1", "J_2", "J_3", "k_1", "k_2", "d_1", "d_2", "T_r2", "omega_s")},
        **{name: getattr(p, name) for name in ("L", "R", "k_p", "k_i")},
        **{"loss": p.eta**2 * p.C_m, "gain": p.eta * p.K_T, "drop": p.eta * p.T_f, "back": p.eta * p.K_E},
        **{"kinetic": scale * f.mu_k, "more": scale * (np.asarray(f.mu_s) - f.mu_k), "v_b": f.v_b},
    }
    names = "".join(f"double precision, parameter :: {k} = {number(float(v))}\n" for k, v in values.items())
    start = steady_state(RIG, FRICTION, START_SPEED)
    states = "".join(f"u({i + 1}) = {number(float(x))}\n" for i, x in enumerate(start))
    unused = {"bcnd": "n,p,i,m,u,v,f,j,d", "icnd": "n,p,i,m,u,v,w,x,f,j,d", "fopt": "n,u,i,p,j,f,d,e", "pvls": "n,u,p"}
    return f"""subroutine func(ndim, u, icp, par, ijac, f, dfdu, dfdp)
implicit none
integer, intent(in) :: ndim, icp(*), ijac
double precision, intent(in) :: u(ndim), par(*)
double precision, intent(out) :: f(ndim)
double precision, intent(inout) :: dfdu(ndim,ndim), dfdp(ndim,*)
{names}double precision :: z, torque
z = u(3)/omega_s
torque = (kinetic + more*exp(-v_b*abs(u(3))))*{law}
f(1) = u(3) - u(4)
f(2) = u(4) - u(5)
f(3) = (-d_1*(u(3) - u(4)) - k_1*u(1) - torque)/J_1
f(4) = (d_1*u(3) - (d_1 + d_2)*u(4) + d_2*u(5) + k_1*u(1) - k_2*u(2) - T_r2)/J_2
f(5) = (k_2*u(2) + d_2*u(4) - (loss + d_2)*u(5) + gain*u(6) - drop)/J_3
f(6) = (-R*u(6) - back*u(5) + k_p*(par(1) - u(5)) + k_i*u(7))/L
f(7) = par(1) - u(5)
end subroutine
subroutine stpnt(ndim, u, par, t)
implicit none
integer, intent(in) :: ndim
double precision, intent(inout) :: u(ndim), par(*)
double precision, intent(in) :: t
par(1) = {number(START_SPEED)}
{states}end subroutine
""" + "".join(f"subroutine {name}({arguments})\nend subroutine\n" for name, arguments in unused.items())


def special_point(folder: Path) -> tuple[int, float, int]:
    """Type, speed reference (rad/s) and number of the last point that AUTO wrote; a type < 0 is a failure."""
    rows = [line.split() for line in (folder / "fort.7").read_text(encoding="utf-8").splitlines()]
    last = [row for row in rows if row and row[0] != "0"][-1]
    return int(last[2]), float(last[4]), abs(int(last[1]))


def auto_run(folder: Path) -> dict[str, Any]:
    """Both of AUTO's continuations in a folder with the compiled model: Hopf point, fold, or why there is none."""

    def run(constants: str) -> tuple[int, float, int]:
        (folder / "fort.2").write_text(CONSTANTS + constants, encoding="utf-8")
        subprocess.run(
            ["./model"], cwd=folder, check=True, timeout=TIMEOUT, capture_output=True, env={**os.environ, **ONE_CORE}
        )
        return special_point(folder)

    (folder / "fort.3").unlink(missing_ok=True)
    kind, hopf, _ = run(EQUILIBRIA)
    if kind != HOPF:
        return {"remark": f"no Hopf point; ended at {hopf:.5f} rad/s"}
    shutil.copy(folder / "fort.8", folder / "fort.3")
    kind, speed, points = run(ORBITS)
    if kind != FOLD:
        why = "did not converge (MX)" if kind == -END else "ended"
        return {"hopf": hopf, "remark": f"no fold: {why} at {speed:.5f} rad/s"}
    return {"hopf": hopf, "fold": speed, "remark": f"{points} orbits"}


def auto(law: str, repeats: int) -> dict[str, Any]:
    """AUTO-07p on one law: `auto_run` and its median seconds; a failure in words."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "model.f90").write_text(fortran(law), encoding="utf-8")
        compiler = ["gfortran", "-O2", "-fopenmp", "model.f90", *map(str, sorted(LIBRARY.glob("*.o"))), "-o", "model"]
        try:
            subprocess.run(compiler, cwd=folder, check=True, timeout=TIMEOUT, capture_output=True)
            return {**auto_run(folder), "seconds": median_seconds(lambda: auto_run(folder), repeats)}
        except subprocess.TimeoutExpired as error:
            return {"remark": f"failed: {error.cmd[0]} took longer than {TIMEOUT:.0f} s"}
        except subprocess.CalledProcessError as error:
            return {"remark": f"failed: {error.cmd[0]} ended with status {error.returncode}"}
        except (OSError, ValueError, IndexError) as error:
            return {"remark": f"failed: AUTO's output cannot be read ({error})"}
