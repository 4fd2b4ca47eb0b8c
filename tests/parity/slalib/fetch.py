"""Fetch SLALIB's Fortran, the source distribution of pyslalib, beside a copy of the description.

    python fetch.py FOLDER

Nothing of it is kept in this project: it stands under the GNU General Public License.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tarfile
from pathlib import Path

HERE = Path(__file__).parent
PACKAGE = "pyslalib==1.0.10"


def fetch(folder: Path) -> Path:
    """Return the path of a description in `folder`, the Fortran in its folder `source`.

    Raises
    ------
    RuntimeError
        pip cannot fetch it; its last words.
    """
    source = folder / "source"
    if not source.is_dir():
        download = folder / "download"
        words = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps"]
        words += ["--no-binary", "pyslalib", "--dest", str(download), PACKAGE]
        done = subprocess.run(words, check=False, capture_output=True, text=True)
        archives = list(download.glob("*.tar.gz"))
        if done.returncode or not archives:
            raise RuntimeError(f"pip cannot fetch {PACKAGE}: {done.stderr.strip()[-500:]}")
        with tarfile.open(archives[0]) as archive:
            archive.extractall(download, filter="data")
        next(one for one in download.iterdir() if one.is_dir()).rename(source)
    for name in ("parity.toml", "slalib_erfa.py"):
        shutil.copy(HERE / name, folder)
    return folder / "parity.toml"


if __name__ == "__main__":
    print(fetch(Path(sys.argv[1])))  # noqa: T201
