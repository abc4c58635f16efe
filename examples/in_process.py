"""Run a world inside a program: no network, no second process, as fast as the machine can.

One robot follows its script, another one gets a goal; a sink prints how goals begin and end.
"""

from hmrsim import RunSettings, Simulator, commands, load_world
from hmrsim.interfaces.geometry_msgs import Point, Pose, PoseStamped
from hmrsim.interfaces.nav2_msgs import NavigateToPose
from hmrsim.protocol.outputs import GoalChanged, Output
from hmrsim.protocol.topics import Topic


class Printer:
    """A sink, which receives the outputs of the simulation."""

    def wants(self, _topic: Topic) -> bool:
        """Return False for all topics of samples; changes of goals arrive in any case."""
        return False

    def emit(self, output: Output) -> None:
        """Print the status of a goal."""
        if isinstance(output, GoalChanged):
            print(f"{output.stamp / 1e9:.1f} s: {output.robot} {output.action} {output.status.name}")


world = load_world("examples/in_process.yaml").world
simulator = Simulator(world, RunSettings(seed=3), [Printer()])
goal = NavigateToPose.Goal(pose=PoseStamped(pose=Pose(position=Point(x=4.0, y=0.0))))
simulator.advance(5.0)
simulator.submit(commands.SendGoal("wall_e", "navigate_to_pose", goal))
simulator.run()
print(f"wall_e is at {simulator.robots['wall_e'].pose().point} after {simulator.now:.1f} s")
print(f"the cart's script is {simulator.scripts.all['cart'].state.value}")
