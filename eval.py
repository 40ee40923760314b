"""Compare policies on the same random rigs: `python eval.py --help` tells how."""

import sys

from drillrig_env.cli.evaluate import main

if __name__ == "__main__":
    sys.exit(main(prog="python eval.py"))
