"""Compare policies on the same random rigs: `python eval.py --help` tells how."""

import sys

from drillrig_env.cli import start

if __name__ == "__main__":
    sys.exit(start("evaluate", None, "python eval.py"))
