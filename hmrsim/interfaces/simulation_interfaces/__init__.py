"""What a simulator can be asked, as ROS 2 has it: the package simulation_interfaces, as of kilted (1.6.1).

Kilted has the package's first series: a resource to spawn or to load is two fields, not a message of its own.
"""

from __future__ import annotations

from hmrsim.interfaces.simulation_interfaces.entities import (
    DeleteEntity,
    GetEntities,
    GetEntitiesStates,
    GetEntityInfo,
    GetEntityState,
    GetNamedPoseBounds,
    GetNamedPoses,
    GetSpawnables,
    SetEntityState,
    SpawnEntity,
)
from hmrsim.interfaces.simulation_interfaces.messages import (
    Bounds,
    EntityCategory,
    EntityFilters,
    EntityInfo,
    EntityState,
    NamedPose,
    Resource,
    Result,
    SimulationState,
    SimulatorFeatures,
    Spawnable,
    TagsFilter,
    WorldResource,
)
from hmrsim.interfaces.simulation_interfaces.simulation import (
    GetAvailableWorlds,
    GetCurrentWorld,
    GetSimulationState,
    GetSimulatorFeatures,
    LoadWorld,
    ResetSimulation,
    SetSimulationState,
    SimulateSteps,
    StepSimulation,
)

__all__ = [
    "Bounds",
    "DeleteEntity",
    "EntityCategory",
    "EntityFilters",
    "EntityInfo",
    "EntityState",
    "GetAvailableWorlds",
    "GetCurrentWorld",
    "GetEntities",
    "GetEntitiesStates",
    "GetEntityInfo",
    "GetEntityState",
    "GetNamedPoseBounds",
    "GetNamedPoses",
    "GetSimulationState",
    "GetSimulatorFeatures",
    "GetSpawnables",
    "LoadWorld",
    "NamedPose",
    "ResetSimulation",
    "Resource",
    "Result",
    "SetEntityState",
    "SetSimulationState",
    "SimulateSteps",
    "SimulationState",
    "SimulatorFeatures",
    "SpawnEntity",
    "Spawnable",
    "StepSimulation",
    "TagsFilter",
    "WorldResource",
]
