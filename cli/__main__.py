"""``python -m tfra.cli``."""

import sys

from tfra.cli.main import main

sys.exit(main())
