"""`python -m camtruth`, where its command is not on the path."""

import sys

from camtruth.command import main

if __name__ == "__main__":
    sys.exit(main())
