// What the page's model makes of what happens. Each claim throws if it does not hold; evaluated in a page (base "") or
// in node (base: the folder of the modules), with the small world of test_model.py. Returns what was wrong, by claim.
async ([base, VIEW, prefix = '']) => {
  const { Model } = await import(`${base}/model/model.js`);
  const { Robot } = await import(`${base}/model/robot.js`);
  const { World } = await import(`${base}/model/world.js`);
  const { Motion } = await import(`${base}/model/motion.js`);
  const { numberAt, numbersIn, timeIn } = await import(`${base}/model/topics.js`);
  const { Line } = await import(`${base}/model/history.js`);
  const { Tail } = await import(`${base}/model/tail.js`);
  const { Lines } = await import(`${base}/source/recording.js`);
  const { Playback } = await import(`${base}/source/playback.js`);
  const { asItemIs } = await import(`${base}/model/demand.js`);
  const { errorOf } = await import(`${base}/model/goals.js`);
  const { describe } = await import(`${base}/model/texts.js`);
  const { causeWords, goalWords } = await import(`${base}/model/phrases.js`);
  const { drawCauses } = await import(`${base}/map/fixtures.js`);

  const stamp = (t) => ({ sec: Math.floor(t), nanosec: Math.round((t % 1) * 1e9) });
  const robot = (name, more = {}) => ({
    name, type: 'nurse', radius: 0.3, flies: false, speed: 2, pose: [0, 0, 0], motion: null, route: [], waits: false,
    dock: null, ailments: {}, connected: true, holds: [], battery: { percentage: 1, charging: false }, sensors: [],
    goals: [], ...more,
  });
  const scene = (t, robots = [robot('wall_e'), robot('eve', { pose: [10, 0, 0] })], more = {}) => ({
    stamp: stamp(t), robots, items: [{ name: 'medicine', weight: 0.2, at: [10, 10], carrier: null }],
    fixtures: [], closed_lanes: [], faults: [], ...more,
  });
  const event = (t, kind, more = {}) => ({ stamp: stamp(t), kind: `${prefix}${kind}`, ...more });
  const drive = (t, from, to, more = {}) => {
    return event(t, 'motion', { robot: 'wall_e', from, to, duration: 5, lane: ['a', 'b'], ...more });
  };
  const status = (t, number, more = {}) => {
    const goal = { robot: 'wall_e', action: 'navigate_to_pose', goal_id: 'one' };
    return event(t, 'status', { ...goal, status: number, ...more });
  };
  const ORDER = { order: 'food_1', item: 'soup' };
  const placed = (t, more = {}) => event(t, 'order_placed', { ...ORDER, from: 'ward', to: 'charger', within: 30, ...more });
  const delivered = (t, more = {}) => event(t, 'order_delivered', { ...ORDER, lead_time: t - 1, robot: 'eve', ...more });
  const modelOf = (...events) => {
    const model = new Model();
    model.loadView(VIEW);
    model.loadScene(scene(0));
    events.forEach((each) => model.apply(each));
    return model;
  };
  const wallE = (...events) => modelOf(...events).robots.get('wall_e');
  const samplesOf = (events) => [
    [0, '_world/view', VIEW], [0, '_world/scene', scene(0)],
    ...events.map((each) => [each.stamp.sec * 1e9 + each.stamp.nanosec, '_world/events', each]),
  ];
  const still = () => ({ reset(t) { this.t = t; }, setRate() {} });
  const equal = (expected, actual) => {
    const [want, got] = [expected, actual].map((each) => JSON.stringify(each));
    if (want !== got) throw new Error(`expected ${want}, got ${got}`);
  };

  const claims = {
    'a world names its points'() {
      const world = new World(VIEW.world);
      equal([[0, 0], [10, 10]], [world.docks.get('charger').at, world.items.get('medicine').at]);
      equal(['ward', 'charger', ''], [world.nameAt([10, 10]), world.nameAt([0, 0]), world.nameAt([1, 1])]);
      equal([0, 0, 110, 21], [world.extent[0], world.bounds ?? 0, world.extent[2], world.extent[3]]);
    },
    'the nearest lane is found'() {
      const world = new World(VIEW.world);
      equal(['a|b', [4, 0], 1], Object.values(world.nearestLane(4, 1)).map((each) => each.key ?? each));
      equal(null, world.nearestLane(4, 1, 0.5));
    },
    'types keep their numbers, and new ones get the next'() {
      const world = new World(VIEW.world);
      equal([0, 1, 3, 3], ['nurse', 'carrier', 'alien', 'alien'].map((name) => world.typeIndex(name)));
    },
    'a motion is driven at its time'() {
      const there = wallE(drive(1, [0, 0, 0], [10, 0, 0]));
      equal([[0, 0, 0], [5, 0, 0], [10, 0, 0]], [0.5, 3.5, 99].map((t) => there.poseAt(t)));
      equal(['driving', 'idle'], [there.stateAt(3), there.stateAt(6)]);
    },
    'an array that is given is filled'() {
      const out = [9, 9, 9];
      equal(true, wallE(drive(1, [0, 0, 0], [10, 0, 0])).poseAt(2, out) === out);
      equal([2, 0, 0], out);
    },
    'who looks a little back sees the motion before'() {
      const there = wallE(drive(1, [0, 0, 0], [10, 0, 0]), drive(6, [10, 0, 0], [10, 10, 0]));
      equal([9, 0, 0], there.poseAt(5.5));
    },
    'more than half a turn leads the long way round'() {
      const motion = new Motion({ from: [0, 0, 1], to: [0, 0, 6], duration: 10, turned: 5 }, 0);
      equal([0, 0, 3.5], motion.poseAt(5));
    },
    'in a ride one is where it began until it is over'() {
      const motion = new Motion({ from: [0, 0, 1], to: [100, 0, 1], duration: 10, ride: true }, 0);
      equal([[0, 0, 1], [100, 0, 1]], [motion.poseAt(9.9), motion.poseAt(10)]);
    },
    'a stretch is driven from rest to rest'() {
      const motion = new Motion({ from: [0, 0, 0], to: [10, 0, 0], duration: 7, profile: [10, 2, 1, 0] }, 0);
      equal([0.5, 2, 8, 9.5], [1, 2, 5, 6].map((t) => motion.poseAt(t)[0]));
    },
    'a robot stops where it is told to'() {
      const there = wallE(drive(1, [0, 0, 0.5], [10, 0, 0.5]), event(3, 'stopped', { robot: 'wall_e', at: [4, 0] }));
      equal([[4, 0, 0.5], 'idle', []], [there.poseAt(4), there.stateAt(4), there.route]);
    },
    'the route shrinks, and rides are no distance'() {
      const points = [[10, 0], [10, 10], [110, 10], [110, 20]];
      const there = wallE(event(1, 'route', { robot: 'wall_e', points }), drive(1, [0, 0, 0], [10, 0, 0]));
      equal([30, 25], [there.distanceRemaining(1), there.distanceRemaining(3.5)]);
      there.begin(new Motion({ from: [10, 0, 0], to: [10, 10, 0], duration: 5 }, 6));
      equal([points.slice(1), [[0, 0, 1], [10, 0, 6]]], [there.route, there.driven]);
    },
    'a robot drives what it is told at once, one after the other'() {
      const points = [[10, 0], [10, 10], [0, 10]];
      const then = [
        { from: [10, 0, 1], to: [10, 10, 1], duration: 5 },
        { from: [10, 10, 3], to: [0, 10, 3], duration: 10 },
      ];
      const told = event(1, 'motion', { robot: 'wall_e', from: [0, 0, 0], to: [10, 0, 0], duration: 10, lane: null, then });
      const there = wallE(event(1, 'route', { robot: 'wall_e', points }), told);
      equal([[5, 0, 0], 25], [there.poseAt(6), there.distanceRemaining(6)]);
      equal([[10, 4, 1], points.slice(1), 'driving'], [there.poseAt(13), there.route, there.stateAt(13)]);
      equal([[5, 10, 3], [[0, 0, 1], [10, 0, 11], [10, 10, 16]]], [there.poseAt(21), there.driven]);
      equal(['idle', 26], [there.stateAt(26), there.ends]);
      there.stop(21, [5, 10]);
      equal([[5, 10, 3], -Infinity], [there.poseAt(30), there.ends]);
    },
    'a waiting robot names the causes down to the first one, or the circle'() {
      const model = modelOf(event(1, 'waiting', { robot: 'wall_e', at: [1, 0], for: ['eve'] }));
      model.robots.get('eve').put(1, 10, 10, 0);
      equal('eve: idle at ward', causeWords(model.robots.get('wall_e'), model, 4));
      equal('', causeWords(model.robots.get('eve'), model, 4));
      model.apply(event(2, 'waiting', { robot: 'eve', at: [10, 10], for: ['wall_e'] }));
      const circle = 'eve: waiting for wall_e at ward, 3.0 s: they wait for each other in a circle';
      equal(circle, causeWords(model.robots.get('wall_e'), model, 5));
    },
    'a robot in the queue of a dock is held up by the robot in the dock'() {
      const docked = event(1, 'dock_docked', { robot: 'eve', dock: 'charger' });
      const model = modelOf(docked, event(2, 'dock_queued', { robot: 'wall_e', dock: 'charger', position: 1 }));
      equal([['eve'], []], ['wall_e', 'eve'].map((name) => model.robots.get(name).heldBy(model)));
      equal('eve: idle docked at charger', causeWords(model.robots.get('wall_e'), model, 3));
    },
    'an arrow leads from a robot to each that holds it up, thick for a chosen one'() {
      const model = modelOf(event(1, 'waiting', { robot: 'wall_e', at: [1, 0], for: ['eve'] }));
      const robots = [...model.robots.values()];
      const drawn = (selected) => {
        const widths = [];
        let arrows = 0;
        const c = { beginPath() {}, moveTo() {}, lineTo() {}, setLineDash() {} };
        c.quadraticCurveTo = () => arrows += 1;
        c.stroke = () => widths.push([c.lineWidth, arrows]);
        const where = (name) => [name === 'eve' ? 100 : 0, 0, 8];
        drawCauses(c, { model, palette: { states: { waiting: '#e69f00' } }, selected }, { robots, count: 2 }, where);
        return widths;
      };
      equal([[1.5, 1], [3, 1]], drawn(null));
      equal([[1.5, 0], [3, 1]], drawn('wall_e'));
      equal([[1.5, 1], [3, 1]], drawn('eve'));
    },
    'a robot waits for others until it moves'() {
      const model = modelOf(event(1, 'waiting', { robot: 'wall_e', at: [0, 0], for: ['eve'] }));
      const there = model.robots.get('wall_e');
      equal(['waiting', ['eve'], 1], [there.stateAt(1), there.waiting.for, there.waiting.since]);
      model.apply(event(1.5, 'waiting', { robot: 'wall_e', at: [0, 0], why: 'gate is opening' }));
      equal([[], 'gate is opening', 1], [there.waiting.for, there.waiting.why, there.waiting.since]);
      model.apply(drive(2, [0, 0, 0], [10, 0, 0]));
      equal(['driving', null], [there.stateAt(2), there.waiting]);
    },
    'a deadlock is over when one of its robots moves'() {
      const model = modelOf(event(1, 'deadlock', { robots: ['eve', 'wall_e'], lanes: [] }));
      equal([['eve', 'wall_e']], model.deadlocks.map(({ robots }) => robots));
      model.apply(drive(2, [0, 0, 0], [10, 0, 0]));
      equal([], model.deadlocks);
    },
    'a goal is known from its acceptance to its end'() {
      const goal = { pose: { pose: { position: { x: 10, y: 10 } } } };
      const asked = event(1, 'goal', { robot: 'wall_e', action: 'navigate_to_pose', goal_id: 'one', goal });
      const model = modelOf(asked, status(1, 1), status(1, 2));
      equal(['busy', 'one'], [model.robots.get('wall_e').stateAt(1), model.robots.get('wall_e').goal.id]);
      model.setFeedback('wall_e', 'navigate_to_pose', { goal_id: 'one', feedback: { distance_remaining: 3 } });
      model.apply(status(9, 6, { result: { error_code: 208, error_msg: 'no route' } }));
      const { accepted, ended, errorCode, errorMsg, feedback, goal: known } = model.goals.get('one');
      equal([1, 9, 208, 'no route', { distance_remaining: 3 }], [accepted, ended, errorCode, errorMsg, feedback]);
      equal(['to ward', null], [goalWords('navigate_to_pose', known, model.world), model.robots.get('wall_e').goal]);
    },
    'a goal that only follows a robot does not hold it'() {
      const goal = { use_poses: true, goal: { pose: { position: { x: 10, y: 10 } } } };
      const action = 'compute_and_track_route';
      const asked = event(1, 'goal', { robot: 'wall_e', action, goal_id: 'one', goal });
      const model = modelOf(asked, status(1, 1, { action }), status(1, 2, { action }));
      equal(['idle', null], [model.robots.get('wall_e').stateAt(1), model.robots.get('wall_e').goal]);
      equal(['to ward', 'to waypoint 7'], [goalWords(action, goal, model.world), goalWords(action, { goal_id: 7 })]);
    },
    'errors are those of Nav2, MoveIt or the simulation'() {
      equal([208, 'x'], errorOf({ error_code: 208, error_msg: 'x' }));
      equal([-19, 'y'], errorOf({ error_code: { val: -19, message: 'y' } }));
      equal([[null, ''], [null, '']], [errorOf({ error_code: { val: 1, message: '' } }), errorOf(undefined)]);
      equal([null, 'z'], errorOf({ result: { result: 4, error_message: 'z' } }));
    },
    'at most 2,000 goals are kept, and those that go on are'() {
      const model = modelOf(status(0, 2, { goal_id: 'long' }));
      for (let i = 0; i < 5000; i += 1) model.apply(status(1, 4, { goal_id: `g${i}` }));
      equal([true, true, true], [model.goals.size <= 2000, model.goals.has('long'), model.goals.has('g4999')]);
    },
    'items are carried and laid down'() {
      const model = modelOf(event(1, 'picked', { robot: 'wall_e', item: 'medicine' }));
      equal(['wall_e', ['medicine']], [model.items.get('medicine').carrier, model.robots.get('wall_e').holds]);
      model.apply(event(2, 'dropped', { robot: 'wall_e', item: 'medicine', at: [3, 4] }));
      equal([null, [3, 4]], [model.items.get('medicine').carrier, model.items.get('medicine').at]);
      equal([], model.robots.get('wall_e').holds);
    },
    'docks have robots and a queue'() {
      const queued = event(1, 'dock_queued', { robot: 'wall_e', dock: 'charger', position: 1 });
      const model = modelOf(event(1, 'dock_docked', { robot: 'eve', dock: 'charger' }), queued);
      const inside = () => [model.docks.get('charger').docked, model.docks.get('charger').queue];
      equal([['eve'], ['wall_e']], inside());
      model.apply(event(2, 'dock_undocked', { robot: 'eve', dock: 'charger' }));
      model.apply(event(3, 'dock_docked', { robot: 'wall_e', dock: 'charger' }));
      equal([['wall_e'], []], inside());
    },
    'doors open, close, are locked and jam'() {
      const model = modelOf(event(1, 'door_opening', { door: 'gate', by: 'eve' }));
      const gate = () => {
        const { state, locked, jammed } = model.doors.get('gate');
        return [state, locked ? 'locked' : '', jammed ? 'jammed' : ''].filter(Boolean).join(' ');
      };
      equal('opening', gate());
      model.apply(event(2, 'door_opened', { door: 'gate', by: 'eve' }));
      model.apply(event(3, 'fault_began', { fault: 'door_jammed', name: 'rust', door: 'gate' }));
      equal('open jammed', gate());
      model.apply(event(4, 'fault_ended', { fault: 'door_jammed', name: 'rust', door: 'gate' }));
      model.apply(event(5, 'door_closed', { door: 'gate' }));
      model.apply(event(5, 'lane_closed', { lane: ['a', 'b'], why: 'gate is locked' }));
      equal('closed locked', gate());
      model.apply(event(6, 'lane_opened', { lane: ['a', 'b'] }));
      equal('closed', gate());
    },
    'a lift carries robots from stop to stop'() {
      const left = event(1, 'lift_departed', { lift: 'lift', from: 'c', to: 'up', robots: ['eve'] });
      const model = modelOf(left);
      const state = () => ['stop', 'to', 'at'].map((field) => model.lifts.get('lift')[field]);
      equal(['c', 'up', [10, 10]], state());
      model.apply(event(11, 'lift_arrived', { lift: 'lift', stop: 'up', robots: [] }));
      equal(['up', null, [110, 10]], state());
    },
    'faults do what they do, two of a kind one by one'() {
      const lost = (t, kind, name) => event(t, kind, { fault: 'messages_lost', name, robot: 'wall_e' });
      const model = modelOf(lost(1, 'fault_began', 'x'), lost(2, 'fault_began', 'y'), lost(3, 'fault_ended', 'x'));
      equal('offline', model.robots.get('wall_e').stateAt(3));
      model.apply(lost(4, 'fault_ended', 'y'));
      model.apply(event(5, 'fault_began', { fault: 'breakdown', name: 'tyre', robot: 'wall_e' }));
      equal(['stopped', ['tyre']], [model.robots.get('wall_e').stateAt(5), [...model.faults.keys()]]);
    },
    'the numbers of a message have paths, without headers and long lists'() {
      const message = { header: { stamp: stamp(2.5), seq: 1 }, pose: { x: 1, name: 'a' }, cells: [3, null], covariance: Array(36).fill(0) };
      equal(['pose.x', 'cells.0'], numbersIn(message));
      equal([1, 3, undefined, undefined], ['pose.x', 'cells.0', 'pose.name', 'pose.toString.length'].map((path) => numberAt(message, path)));
      equal([2.5, undefined], [timeIn(message), timeIn({ x: 1 })]);
    },
    'a line keeps few points, and begins anew with time'() {
      const line = new Line(1);
      for (let t = 0; t < 5000; t += 0.5) line.add(t, t);
      equal([true, 0, 4999.5], [line.points.length <= 300, line.points[0][0], line.points.at(-1)[0]]);
      line.add(3, 1);
      equal([[3, 1]], line.points);
    },
    'batteries are charged and empty'() {
      const model = modelOf(event(1, 'charging_began', { robot: 'wall_e', percentage: 0.5 }));
      equal('charging', model.robots.get('wall_e').stateAt(1));
      model.setBattery('wall_e', { header: { stamp: stamp(5) }, percentage: 0.6, power_supply_status: 2 });
      equal({ percentage: 0.6, charging: false }, model.robots.get('wall_e').battery);
      equal([[0, 1], [1, 0.5], [5, 0.6]], model.history.batteries.get('wall_e').points);
      model.apply(event(6, 'battery_empty', { robot: 'wall_e', percentage: 0, at: [1, 2] }));
      equal('stopped', model.robots.get('wall_e').stateAt(6));
    },
    'robots come and go'() {
      const model = modelOf(event(1, 'spawned', { entity: 'm_o', type: 'nurse', at: [3, 4] }));
      equal([[3, 4, 0], 0.3], [model.robots.get('m_o').poseAt(1), model.robots.get('m_o').radius]);
      model.apply(event(2, 'teleported', { entity: 'm_o', at: [5, 6], yaw: 1 }));
      equal([5, 6, 1], model.robots.get('m_o').poseAt(2));
      model.apply(event(3, 'deleted', { entity: 'm_o' }));
      equal(false, model.robots.has('m_o'));
    },
    'a robot that no scene had is there when it moves'() {
      const model = modelOf(drive(1, [1, 1, 0], [2, 1, 0], { robot: 'stranger' }));
      equal([2, 1, 0], model.robots.get('stranger').poseAt(9));
    },
    'unknown kinds and missing fields break nothing'() {
      const kinds = ['motion', 'route', 'stopped', 'teleported', 'waiting', 'went_on', 'deadlock', 'made_room', 'goal',
        'lane_closed', 'lane_opened', 'status', 'picked', 'placed', 'dropped', 'dock_queued', 'dock_docked', 'reset',
        'dock_undocked', 'battery_low', 'battery_empty', 'battery_full', 'charging_began', 'door_opening', 'planner',
        'door_closed', 'lift_departed', 'lift_arrived', 'lift_called', 'fault_began', 'fault_ended', 'fault_missed',
        'spawned', 'deleted', 'participant_joined', 'participant_left', 'script_ended', 'simulation_state',
        'plan_wanted', 'rejected', 'rerouted', 'world_loaded', 'of_tomorrow'];
      const model = modelOf();
      for (const kind of kinds) {
        for (const more of [{}, { robot: 'wall_e' }, { robot: 'nobody' }, { door: 'gate', lift: 'lift', name: 'x' }]) {
          const each = event(1, kind, more);
          model.apply(each);
          const { severity, subject, text } = describe(each, model);
          equal(['string', 'string', true], [typeof severity, typeof subject, text.length > 0]);
        }
        model.apply({ kind });
      }
      [undefined, null, {}, { kind: 7 }].forEach((each) => model.apply(each));
      new Model().loadScene({});
      new Model().loadView({ world: {} });
      model.flush();
    },
    'events are kept without motions and routes'() {
      const model = modelOf(drive(1, [0, 0, 0], [1, 0, 0]), event(2, 'rerouted', { robot: 'wall_e' }), event(3, 'new'));
      equal([['rerouted', 2], ['new', 3]], model.events.map(({ kind, t }) => [kind.slice(prefix.length), t]));
    },
    'events are told by the templates of the server, points by their names'() {
      const model = modelOf();
      const said = (...given) => Object.values(describe(event(...given), model)).slice(0, 3);
      equal(['wall_e', 'stops at charger', 'debug'], said(1, 'stopped', { robot: 'wall_e', at: [0, 0] }));
      equal(['', `${prefix}of tomorrow`.replace('_', ' '), 'info'], said(1, 'of_tomorrow'));
    },
    'what happened before the first scene is in the log, and goals of it are known'() {
      const model = new Model();
      model.loadView(VIEW);
      const old = { goal_id: 'old', robot: 'wall_e' };
      const asked = event(1, 'goal', { robot: 'wall_e', action: 'navigate_to_pose', goal_id: 'one', goal: { a: 1 } });
      model.loadLog([status(8, 1, old), event(9, 'reset'), asked, status(1, 1), status(2, 4), event(5, 'now')], 5);
      model.loadScene(scene(5));
      equal(['status', 'reset', 'goal', 'status', 'status'], model.events.map(({ kind }) => kind.slice(prefix.length)));
      equal([['one', { a: 1 }, 4, 1, 2]], [...model.goals.values()].map((one) => [one.id, one.goal, one.status, one.accepted, one.ended]));
    },
    'how long a goal took is not known if it was accepted before the log begins'() {
      const model = new Model();
      model.loadView(VIEW);
      model.loadLog([status(2, 4)], 5);
      equal([[null, 2]], [...model.goals.values()].map(({ accepted, ended }) => [accepted, ended]));
    },
    'listeners are told once a flush'() {
      const model = modelOf();
      model.flush();
      const heard = [];
      for (const kind of ['events', 'goals', 'robots', 'scene']) model.addEventListener(kind, () => heard.push(kind));
      model.apply(status(1, 1));
      model.apply(status(1, 2));
      equal([], heard);
      model.flush();
      model.flush();
      equal(['events', 'goals', 'robots'], heard.sort());
    },
    'robots are counted by state over time, at most 1,000 times'() {
      const model = modelOf(drive(1.5, [0, 0, 0], [10, 0, 0]), event(4, 'new'));
      equal([[0, 0], [1, 0], [2, 1], [4, 1]], model.history.counts.points.map(([t, { driving }]) => [t, driving]));
      for (let t = 5; t < 9000; t += 1) model.apply(event(t, 'new'));
      const { points } = model.history.counts;
      equal([true, 2], [points.length <= 1000 && points.length > 400, points.at(-1)[1].idle]);
    },
    'a scene tells of goals that ended unheard'() {
      const model = modelOf(status(1, 2));
      model.loadScene(scene(5));
      equal([0, 5, null], [model.goals.get('one').status, model.goals.get('one').ended, model.robots.get('wall_e').goal]);
    },
    'a goal that ended before the scene lasted as long as the scene says'() {
      const ended = { action: 'wait', goal_id: 'old', stamp: stamp(2), ended: stamp(5), status: 4, result: {} };
      const model = modelOf();
      model.loadScene(scene(90, [robot('wall_e', { goals: [ended] })]));
      equal([2, 5], [model.goals.get('old').accepted, model.goals.get('old').ended]);
    },
    'a simulator that begins anew leaves no goal running, and the same world the same'() {
      const model = modelOf(status(1, 2));
      const { world } = model;
      model.loadView(structuredClone(VIEW));
      equal([0, true, 'idle'], [model.goals.get('one').status, model.world === world, model.robots.get('eve').stateAt(0)]);
    },
    'another world has other robots and goals, and the log goes on'() {
      const model = modelOf(status(1, 2), event(2, 'world_loaded', { name: 'other' }));
      model.loadView({ world: { robots: [{ name: 'm_o', type: 'nurse', at: [1, 2], yaw: 0 }] } });
      equal([['m_o'], 0, 2], [[...model.robots.keys()], model.goals.size, model.events.length]);
    },
    'a scene that comes again changes nothing'() {
      const model = modelOf(drive(1, [0, 0, 0], [10, 0, 0]), event(6, 'waiting', { robot: 'wall_e', for: ['eve'] }));
      const there = model.robots.get('wall_e');
      model.loadScene(scene(7, [robot('wall_e', { pose: [10, 0, 0], waits: true, waiting: { since: 6, for: ['eve'] } }), robot('eve')]));
      equal([true, ['eve'], 6], [there === model.robots.get('wall_e'), there.waiting.for, there.waiting.since]);
      equal([[0, 0, 1]], there.driven);
    },
    'what is saved comes back, whatever happens after'() {
      const model = modelOf(drive(1, [0, 0, 0], [10, 0, 0]), status(1, 1));
      const there = model.robots.get('wall_e');
      const saved = model.snapshot();
      const before = [there.poseAt(3), [...there.driven], [...model.goals.keys()], model.events.length];
      model.apply(drive(6, [10, 0, 0], [10, 10, 0]));
      model.apply(status(7, 4));
      model.apply(event(8, 'deleted', { entity: 'wall_e' }));
      for (let i = 0; i < 2; i += 1) {
        model.restore(saved);
        const now = model.robots.get('wall_e');
        equal(before, [now.poseAt(3), now.driven, [...model.goals.keys()], model.events.length]);
        model.apply(drive(6, [10, 0, 0], [10, 10, 0]));
      }
    },
    'an order is open from its coming to its delivery'() {
      const model = modelOf(placed(1));
      const { demand } = model;
      equal([['ward', 'charger', 1, 31, 'waiting']], [...demand.open.values()].map((each) => {
        return [each.from, each.to, each.placed, each.due, each.state];
      }));
      model.apply(event(31, 'order_late', { ...ORDER, to: 'charger' }));
      equal(true, demand.open.get('food_1').late);
      model.apply(delivered(36, { late: 5 }));
      equal([0, { placed: 1, delivered: 1, late: 1, lost: 0 }], [demand.open.size, demand.totals]);
      equal(['ward', 'charger', 'eve', 36, 35, 5], ['from', 'to', 'robot', 'ended', 'lead', 'lateBy'].map((each) => demand.ended[0][each]));
    },
    'an order whose coming is not known is shown by what happens to it'() {
      const { demand } = modelOf(event(5, 'order_picked_up', { ...ORDER, robot: 'eve' }), event(6, 'order_lost', { order: 'x', item: 'y' }));
      equal(['soup', 'carried', 'eve', null], ['item', 'state', 'robot', 'placed'].map((each) => demand.open.get('food_1')[each]));
      equal([['x', 'lost', '']], demand.ended.map(({ name, state, robot: by }) => [name, state, by]));
    },
    'an order whose item is put down on the way waits again'() {
      const model = modelOf(placed(1), event(2, 'picked', { item: 'soup', robot: 'eve' }),
        event(2, 'order_picked_up', { ...ORDER, robot: 'eve' }));
      const how = () => Object.values(asItemIs(model.demand.open.get('food_1'), model.items)).slice(5, 7);
      equal(['carried', 'eve'], how());
      model.apply(event(3, 'dropped', { item: 'soup', robot: 'eve', at: [1, 1] }));
      equal(['waiting', ''], how());
    },
    'what the simulator says of the orders counts, and what has happened since'() {
      const model = modelOf(placed(1), event(5, 'order_lost', { order: 'x', item: 'y' }), placed(9, { order: 'food_9' }));
      const orders = [{ name: 'food_1', item: 'soup', at: 'ward', to: 'charger', placed: stamp(1), due: null }, { name: 'old', item: 'tea' }];
      const totals = { placed: 7, delivered: 4, late: 0, lost: 1 };
      for (let i = 0; i < 2; i += 1) {
        model.receive('_world/demand', { stamp: stamp(8), orders, totals });
        equal([['food_1', 'old', 'food_9'], 8, 1], [[...model.demand.open.keys()], model.demand.totals.placed, model.demand.ended.length]);
      }
      equal([1, null, null], [...model.demand.open.values()].slice(0, 2).flatMap((each) => [each.placed, each.due]).slice(0, 3));
      model.receive('_world/demand', { stamp: stamp(12), orders: [], totals: { ...totals, placed: 8, delivered: 7 } });
      model.apply(delivered(11));
      equal([0, 7, 'ward'], [model.demand.open.size, model.demand.totals.delivered, model.demand.ended.at(-1).from]);
    },
    'a reset takes all orders away, and what is saved comes back'() {
      const model = modelOf(placed(1), placed(2, { order: 'food_2' }), delivered(3));
      const saved = model.snapshot();
      model.apply(event(4, 'reset', { scope: 2 }));
      equal([0, 0, 0], [model.demand.open.size, model.demand.ended.length, model.demand.totals.placed]);
      model.restore(saved);
      equal([['food_2'], 1, 2], [[...model.demand.open.keys()], model.demand.ended.length, model.demand.totals.placed]);
    },
    'a tail keeps the last, and its beginnings come back'() {
      const tail = new Tail(4);
      for (let i = 0; i < 5; i += 1) tail.push(i);
      const saved = tail.copy();
      for (let i = 5; i < 20; i += 1) tail.push(i);
      equal([true, 19], [tail.length >= 4 && tail.length <= 6, tail.last]);
      equal([0, 1, 2, 3, 4], saved.items);
    },
    'a recording may be cut anywhere'() {
      const bytes = new TextEncoder().encode('[1,"_world/events",{"kind":"é"}]\n\n[2,"x",{}]\n[3,"_wor');
      for (let cut = 0; cut <= bytes.length; cut += 1) {
        const lines = new Lines();
        lines.add(bytes.slice(0, cut));
        lines.add(bytes.slice(cut));
        equal([false, [1, 2]], [lines.end(), lines.samples.map(([time]) => time)]);
        equal('é', lines.samples[0][2].kind);
      }
    },
    async 'seeking is as playing, forwards and backwards'() {
      const events = [];
      for (let i = 0; i < 9000; i += 1) {
        const from = [i, 0, 0];
        events.push(i % 3 ? drive(i, from, [i + 1, 0, 0], { duration: 0.5 }) : status(i, 1 + (i % 6), { goal_id: `${i}` }));
      }
      const clock = still();
      const playback = new Playback({ name: 'x', samples: samplesOf(events), truncated: false }, new Model(), clock);
      await playback.prepared;
      for (const time of [8999, 10, 4567.25, 4568, 0, 6000.5]) {
        playback.seek(time);
        const played = modelOf(...events.filter(({ stamp: { sec } }) => sec <= time));
        const seen = (model) => {
          const there = model.robots.get('wall_e');
          return [there.poseAt(time), there.driven, there.goals.length, [...model.goals.keys()], model.events.length];
        };
        equal(seen(played), seen(playback._model));
        equal(time, clock.t);
      }
    },
    async 'one jumps from mark to mark, and the end is the end'() {
      const fault = { fault: 'slip', name: 'wet', robot: 'wall_e' };
      const events = [event(1, 'fault_began', fault), status(2, 6), event(3, 'deadlock', { robots: ['eve'] }), event(9, 'x')];
      const playback = new Playback({ name: 'x', samples: samplesOf(events), truncated: true }, new Model(), still());
      equal([['fault', 1], ['aborted', 2], ['deadlock', 3]], playback.marks.map(({ kind, t }) => [kind, t]));
      equal([1, 2, 1, undefined], [1, 1, -1, -1].map((direction) => playback.jump(direction)?.t));
      playback.speed = 4;
      playback.play();
      playback.advance(1000);
      playback.advance(1500);
      equal([3, true], [playback.time, playback.playing]);
      playback.advance(9000);
      equal([9, false], [playback.time, playback.playing]);
    },
    async 'time goes on in a recording where a simulation begins anew'() {
      const samples = samplesOf([event(5, 'x'), event(0, 'reset', { scope: 255 }), event(2, 'y')]);
      const clock = still();
      const playback = new Playback({ name: 'x', samples, truncated: false }, new Model(), clock);
      playback.seek(Infinity);
      equal([7, 2], [playback.end, clock.t]);
      playback.seek(4);
      equal([4, 4], [playback.time, clock.t]);
    },
    'a robot is in one state at a time, the first that counts'() {
      const there = new Robot('x', 'y');
      const states = [there.stateAt(0)];
      there.goals = [{ action: 'wait' }];
      states.push(there.stateAt(0));
      there.battery = { percentage: 1, charging: true };
      states.push(there.stateAt(0));
      there.begin(new Motion({ from: [0, 0, 0], to: [1, 0, 0], duration: 1 }, 0));
      states.push(there.stateAt(0));
      there.wait(0.5, { why: 'a door' });
      states.push(there.stateAt(1));
      there.disable('breakdown', 'broken');
      states.push(there.stateAt(1));
      there.connected = false;
      equal(['idle', 'busy', 'charging', 'driving', 'waiting', 'stopped', 'offline'], [...states, there.stateAt(1)]);
    },
  };
  const wrong = {};
  for (const [claim, check] of Object.entries(claims)) {
    try {
      await check();
    } catch (error) {
      wrong[claim] = String(error.stack ?? error);
    }
  }
  return { claims: Object.keys(claims).length, wrong };
};
