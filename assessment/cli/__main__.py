"""`python -m assessment.cli`: the command line without its script."""

import sys

from assessment.cli.main import main

if __name__ == "__main__":
    sys.exit(main())
