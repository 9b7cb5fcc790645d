"""`python -m armside`: the command `armside`."""

import sys

from .scripts.cli import main

sys.exit(main())
