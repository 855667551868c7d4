"""The one place where Open3D is imported.

Open3D's wheel needs ``libusb-1.0.so.0``, which a bare machine lacks. The package ``libusb-package`` carries
it; loaded with global visibility before Open3D, the dynamic linker finds it already there. It also links to
EGL, OpenGL and X11, which no package carries: where they are missing, the error says how to install them.
"""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from types import ModuleType
from typing import Final

from enfilade.errors import InputError

_VIEWER: Final = "open3d.visualization"


@cache
def open3d() -> ModuleType:
    """Return the ``open3d`` module, its native needs loaded first and its chatter turned down.

    Raises
    ------
    InputError
        A system library that Open3D links to is missing.
    """
    import libusb_package

    library = libusb_package.get_library_path()
    if library is not None:
        ctypes.CDLL(str(library), mode=ctypes.RTLD_GLOBAL)
    try:
        with _without_viewer():
            import open3d as module
    except ImportError as error:
        raise InputError(
            f"Open3D cannot be loaded ({error}); on Debian install what it links to: "
            "apt-get install libegl1 libgl1 libx11-6 libgomp1"
        ) from error

    module.utility.set_verbosity_level(module.utility.VerbosityLevel.Error)
    return module


@contextmanager
def _without_viewer() -> Iterator[None]:
    """Keep Open3D from importing its viewer: Dash and Plotly take longer to import than all the rest of it.

    Who wants the viewer after that can still import it by its name.
    """
    if _VIEWER in sys.modules:
        yield
        return
    sys.modules[_VIEWER] = ModuleType(_VIEWER)
    try:
        yield
    finally:
        del sys.modules[_VIEWER]
