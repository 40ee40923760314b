"""`python -m drillrig_env.cli`: the command `drillrig` where it is not on the path."""

import sys

from drillrig_env.cli import main

if __name__ == "__main__":
    sys.exit(main())
