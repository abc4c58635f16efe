"""Patrol a fence, and read the battery before each stop."""

from hmrsim_zenoh import GoalFailed, GoalRejectedError, NotCharging, RequestError, Unreachable

ROUNDS = 12
TRIES = 12
PAUSE = 25.0
LOW = 0.3


async def patrol(client):
    """Visit both ends of the fence twelve times, and charge in between if the battery is low."""
    eve = client.robot("eve")
    for _ in range(ROUNDS):
        for stop in ("post", "corner", "post", "gate"):
            if await read_charge(client, eve) < LOW and not await recharge(client, eve):
                return False
            if not await drive(client, eve, stop):
                return False
    return await recharge(client, eve)


async def read_charge(client, robot):
    """Return the share that is left, once the robot can be reached."""
    while True:
        try:
            return (await robot.battery()).percentage
        except (RequestError, Unreachable):
            await client.sleep(5)


async def drive(client, robot, stop):
    """Drive to a stop, and try again after a pause; return whether the robot has arrived."""
    for _ in range(TRIES):
        try:
            await robot.navigate_to(stop)
        except (GoalFailed, GoalRejectedError):
            await client.sleep(PAUSE)
        else:
            return True
    return False


async def recharge(client, robot):
    """Charge at the dock; return whether that worked."""
    for _ in range(TRIES):
        try:
            await robot.dock("charger")
            await robot.wait_until_charged(0.8)
        except (GoalFailed, GoalRejectedError, NotCharging, RequestError, Unreachable):
            await client.sleep(PAUSE)
        else:
            return True
    return False
