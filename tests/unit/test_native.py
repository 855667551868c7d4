"""Open3D comes without its viewer, which can still be had."""

from __future__ import annotations

import subprocess
import sys


def test_open3d_is_imported_without_its_viewer_and_the_viewer_on_demand() -> None:
    program = (
        "import sys\n"
        "from enfilade.native import open3d\n"
        "assert open3d().t.geometry.RaycastingScene()\n"
        "assert 'plotly' not in sys.modules and 'open3d.visualization' not in sys.modules\n"
        "import open3d.visualization as viewer\n"
        "assert callable(viewer.draw_plotly)\n"
    )
    subprocess.run([sys.executable, "-c", program], check=True)
