"""``python -m tfra.cli``."""

import sys

from tfra.cli.entry import main

sys.exit(main())
