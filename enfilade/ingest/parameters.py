"""The parameters of all stages, each with its default."""

from __future__ import annotations

from dataclasses import dataclass, field

from enfilade.descriptors import DEFAULT_LAYOUT, Layout

from .glimpses import GlimpseParameters
from .groups import GroupParameters
from .inside import InsideParameters
from .neighbours import NeighbourParameters
from .objects import ObjectParameters
from .openings import OpeningParameters
from .planes import PlaneParameters
from .plans import RoomPlanParameters
from .readers import ReadingParameters
from .registration import RegistrationParameters
from .rooms import RoomParameters
from .sparse import SparseParameters
from .storeys import StoreyParameters
from .surfels import SurfelParameters
from .thinning import ThinningParameters


@dataclass(frozen=True, slots=True)
class Parameters:
    """One field a stage, in order; the resolved set is stored on the building."""

    reading: ReadingParameters = field(default_factory=ReadingParameters)
    thinning: ThinningParameters = field(default_factory=ThinningParameters)
    surfels: SurfelParameters = field(default_factory=SurfelParameters)
    registration: RegistrationParameters = field(default_factory=RegistrationParameters)
    planes: PlaneParameters = field(default_factory=PlaneParameters)
    sparse: SparseParameters = field(default_factory=SparseParameters)
    groups: GroupParameters = field(default_factory=GroupParameters)
    rooms: RoomParameters = field(default_factory=RoomParameters)
    plans: RoomPlanParameters = field(default_factory=RoomPlanParameters)
    inside: InsideParameters = field(default_factory=InsideParameters)
    glimpses: GlimpseParameters = field(default_factory=GlimpseParameters)
    storeys: StoreyParameters = field(default_factory=StoreyParameters)
    neighbours: NeighbourParameters = field(default_factory=NeighbourParameters)
    openings: OpeningParameters = field(default_factory=OpeningParameters)
    objects: ObjectParameters = field(default_factory=ObjectParameters)
    descriptors: Layout = DEFAULT_LAYOUT
