"""A controller of some robots in lockstep, with nothing but Zenoh and JSON: a mission that a seed decides.

``python controller.py ENDPOINT NAME ROBOT,… [--seed N] [--turns N] [--pause S] [--stall TURN]``
"""

from __future__ import annotations

import argparse
import json
import random
import signal
import time
from functools import partial

import zenoh

PLACES = ((6.0, 18.0), (15.0, 18.0), (6.0, 5.0), (22.6, 17.5), (34.6, 17.5), (30.6, 6.5), (27.0, 12.8), (99.0, 99.0))
WAKES = (["result"], ["result"], ["result", "status"], ["result", "feedback"])

say = partial(print, flush=True)


class Refused(Exception):
    """The simulator replied with an error."""


class Mission:
    """Decides the next commands by the seed and by the simulator's answers."""

    def __init__(self, seed, robots):
        self._chance = random.Random(seed)
        self._idle = dict.fromkeys(robots)
        self._running = {}

    def commands(self):
        """Return goals for idle robots, and sometimes a cancel."""
        chance = self._chance
        commands = [self._goal(robot) for robot in self._idle]
        self._idle.clear()
        if self._running and chance.random() < 0.2:
            goal_id, (robot, action) = chance.choice([*self._running.items()])
            commands.append({"robot": robot, "action": action, "cancel": goal_id})
        return commands

    def limits(self, now):
        """Return the limit of the advance, and the events that end it earlier."""
        until = now + self._chance.uniform(0.0, 15.0) if self._chance.random() < 0.5 else None
        return {"until": until, "wake": self._chance.choice(WAKES)}

    def take(self, commands, granted):
        """Update the running goals and the idle robots."""
        for command, answer in zip(commands, granted["accepted"], strict=True):
            if "goal" in command:
                self._running[answer["goal_id"]] = command["robot"], command["action"]
        for event in granted["events"]:
            if event["kind"] == "result" and event["goal_id"] in self._running:
                robot, _ = self._running.pop(event["goal_id"])
                self._idle[robot] = None

    def _goal(self, robot):
        if self._chance.random() < 0.3:
            return {"robot": robot, "action": "wait", "goal": {"time": {"sec": self._chance.randrange(5)}}}
        x, y = self._chance.choice(PLACES)
        goal = {"pose": {"pose": {"position": {"x": x, "y": y}}}}
        return {"robot": robot, "action": "navigate_to_pose", "goal": goal}


def ask(session, what, request):
    """Return the answer to a request about time."""
    for reply in session.get(f"hmrsim/_world/time/{what}", payload=json.dumps(request), timeout=1e6):
        if reply.ok is None:
            raise Refused(json.loads(reply.err.payload.to_bytes())["error"])
        return json.loads(reply.ok.payload.to_bytes())
    raise SystemExit("the simulator is gone")


def play(session, args, turns):
    """Take part for the remaining turns."""
    joined = ask(session, "join", {"name": args.name})
    say("joined")
    mission, epoch, now = Mission(f"{args.seed}/{args.name}", args.robots.split(",")), joined["epoch"], joined["now"]
    for turn in turns:
        if turn == args.stall:
            say("thinking")
            signal.sigwait({signal.SIGCONT})
        time.sleep(random.SystemRandom().uniform(0.0, args.pause))
        commands = mission.commands()
        request = {"participant": args.name, "epoch": epoch, "commands": commands, **mission.limits(now)}
        granted = ask(session, "advance", request)
        if granted["reason"] == "end":
            say("end")
            return
        mission.take(commands, granted)
        epoch, now = granted["epoch"], granted["now"]
    ask(session, "leave", {"participant": args.name})
    say("left")


def main():
    """Take part; print a rejection and join again."""
    parser = argparse.ArgumentParser()
    parser.add_argument("endpoint")
    parser.add_argument("name")
    parser.add_argument("robots")
    parser.add_argument("--seed", default="7")
    parser.add_argument("--turns", type=int, default=25)
    parser.add_argument("--pause", type=float, default=0.0)
    parser.add_argument("--stall", type=int)
    args = parser.parse_args()
    # Before there are threads, which inherit it: the signal is for `sigwait`.
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGCONT})
    config = zenoh.Config()
    config.insert_json5("mode", '"client"')
    config.insert_json5("connect/endpoints", json.dumps([args.endpoint]))
    turns = iter(range(args.turns))
    with zenoh.open(config) as session:
        token = session.liveliness().declare_token(f"hmrsim/_participant/{args.name}")
        try:
            play(session, args, turns)
        except Refused as refused:
            say(f"refused: {refused}")
            play(session, args, turns)
        token.undeclare()


if __name__ == "__main__":
    main()
