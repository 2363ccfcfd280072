"""The command `raceway`: the binary of this package with the same arguments."""

import os
import subprocess
import sys

from ._server import binary


def main() -> None:
    """Replaces this process by the binary; where the system cannot, waits for it and returns its exit status."""
    command = [str(binary()), *sys.argv[1:]]
    if os.name == "posix":
        os.execv(command[0], command)
    sys.exit(subprocess.run(command).returncode)


if __name__ == "__main__":
    main()
