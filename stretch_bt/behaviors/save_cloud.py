"""Keeping a cloud."""

from pathlib import Path

from stretch_bt.perception.clouds.cloud import Cloud
from stretch_bt.tree.ports import Behavior, In, Out, Status
from stretch_bt.tree.registry import node


@node
class SaveCloud(Behavior):
    """Write a cloud into the record of the run, as PLY and as a picture; without a record only its points are counted."""

    kind = "perception"
    instant = True
    cloud: In[Cloud]  # cloud to be kept
    file: In[str] = "cloud"  # name of the files, without ending
    points: Out[int]  # number of points of the cloud

    def update(self) -> Status:
        """Write."""
        folder = self.context.folder
        if folder is not None:
            for ending in ("ply", "png"):
                path = folder / f"{Path(self.file).name}.{ending}"
                path.unlink(missing_ok=True)
                self.cloud.save(path)
        self.points = len(self.cloud)
        return Status.SUCCESS
