// How the page keeps in step with a simulator, before a connection that is made up. Returns what was wrong, by claim.
async ([base, VIEW]) => {
  const { Model } = await import(`${base}/model/model.js`);
  const { Live } = await import(`${base}/source/live.js`);
  const { SimClock } = await import(`${base}/source/clock.js`);
  const { Rewind } = await import(`${base}/source/rewind.js`);

  const stamp = (t) => ({ sec: Math.floor(t), nanosec: Math.round((t % 1) * 1e9) });
  const ANSWERS = {
    '_world/view': VIEW,
    '_world/info': { robots: [{ name: 'wall_e' }] },
    '_world/time/state': { now: 5, clock: 'realtime', real_time_factor: 1, paused: true, participants: [] },
    '_world/scene': { stamp: stamp(5), robots: [{ name: 'wall_e', pose: [0, 0, 0] }] },
    '_world/demand': { stamp: stamp(5), orders: [{ name: 'food_1', item: 'soup' }], totals: { placed: 3 } },
  };

  /** A simulator that stands at 5 s. */
  class Made extends EventTarget {
    alive = true;
    asked = [];
    at = [];
    heard = new Map();
    subscribe(key, onSample, { onLost } = {}) {
      this.heard.set(key, { tell: (payload) => onSample(payload, key), lose: onLost });
      return () => this.heard.delete(key);
    }
    async get(key) {
      this.asked.push(key);
      this.at.push(performance.now());
      this.dispatchEvent(new Event('asked'));
      return ANSWERS[key];
    }
    async getAll(key) {
      return ANSWERS[key] ? [[key, await this.get(key)]] : [];
    }
    tell(kind, more = {}, t = 5) {
      this.heard.get('_world/events').tell({ stamp: stamp(t), kind, ...more });
    }
    scenes() {
      return this.at.filter((_, i) => this.asked[i] === '_world/scene');
    }
  }
  const once = (target, holds) => new Promise((then) => {
    const look = () => holds() && then();
    for (const kind of ['asked', 'state', 'events', 'scene', 'robots', 'orders', 'unreadable']) target.addEventListener(kind, look);
    look();
  });
  const begun = async () => {
    const [made, model, clock] = [new Made(), new Model(), new SimClock()];
    const live = new Live(made, model, clock);
    await once(live, () => live.state === 'live');
    return { made, model, clock, live };
  };
  /** A robot that drives 10 m from 1 s to 6 s, seen at 8 s, and the function that a message is heard by. */
  const driven = () => {
    const [model, clock] = [new Model(), new SimClock()];
    model.loadView(VIEW);
    model.loadScene({ stamp: stamp(0), robots: [{ name: 'wall_e', pose: [0, 0, 0] }] });
    clock.reset(8, 0);
    clock.setRate(1, true, 0);
    const rewind = new Rewind(model, clock);
    rewind.start(0);
    const hear = (t, payload, key = '_world/events') => {
      if (rewind.head.receive(key, { stamp: stamp(t), ...payload })) rewind.add(t, key, { stamp: stamp(t), ...payload });
    };
    hear(1, { kind: 'motion', robot: 'wall_e', from: [0, 0, 0], to: [10, 0, 0], duration: 5, lane: ['a', 'b'] });
    return { model, clock, rewind, hear, at: () => [clock.now(), model.robots.get('wall_e')?.poseAt(clock.now())[0]] };
  };
  const equal = (expected, actual) => {
    const [want, got] = [expected, actual].map((each) => JSON.stringify(each));
    if (want !== got) throw new Error(`expected ${want}, got ${got}`);
  };

  const claims = {
    async 'an event that no one can read keeps none of the others waiting'() {
      const { made, model } = await begun();
      made.tell('battery_empty', { robot: 'wall_e', at: 5 });
      made.tell('deadlock', { robots: 5 });
      made.tell('x', {}, 'soon');
      made.heard.get('_world/events').tell(null);
      made.tell('true', {}, 4.5);
      await once(model, () => model.events.length);
      equal([['true'], 4], [model.events.map(({ kind }) => kind), model.unreadable]);
    },
    async 'an event of the far future keeps none of the others waiting'() {
      const { made, model } = await begun();
      made.tell('future', {}, 1e9);
      made.tell('true', {}, 4.5);
      await once(model, () => model.events.length === 2);
    },
    async 'a time that is none is not shown'() {
      const { made, model, clock } = await begun();
      made.heard.get('_world/clock').tell({});
      made.heard.get('_world/time/state').tell({ now: 'late', real_time_factor: 1 });
      made.heard.get('_world/info').tell({ robots: 5 });
      equal([5, 3], [clock.received, model.unreadable]);
    },
    async 'many changes of the scene at once ask for it twice, some time apart'() {
      const { made } = await begun();
      const [before] = made.scenes();
      made.at.length = made.asked.length = 0;
      for (let i = 0; i < 20; i += 1) made.tell('teleported', { entity: 'wall_e', at: [i, 0] }, 4);
      await once(made, () => made.scenes().length === 1);
      equal(true, made.scenes()[0] - before >= 740);
      for (let i = 0; i < 20; i += 1) made.tell('teleported', { entity: 'wall_e', at: [i, 0] }, 4);
      await once(made, () => made.scenes().length === 2);
      equal(true, made.scenes()[1] - made.scenes()[0] >= 740);
    },
    async 'after a loss all is asked for anew, and what waited is forgotten'() {
      const { made, model } = await begun();
      made.tell('waits', {}, 9);
      made.asked.length = 0;
      made.heard.get('_world/events').lose();
      await once(model, () => made.asked.includes('_world/scene'));
      equal(Object.keys(ANSWERS).filter((key) => key !== '_world/demand').sort(), [...made.asked].sort());
      made.tell('after', {}, 5);
      await once(model, () => model.events.length);
      equal(['after'], model.events.map(({ kind }) => kind));
    },
    async 'orders are asked for while they are shown, and anew in another beginning'() {
      const { made, model, live } = await begun();
      const known = () => [model.demand.open.size, model.demand.totals.placed].join();
      live.watchDemand(true);
      await once(model, () => known() === '1,3');
      made.tell('reset', { scope: 2 });
      equal('0,0', known());
      await once(model, () => known() === '1,3');
      made.heard.get('_world/demand').tell({ stamp: stamp(5), orders: [], totals: { placed: 4 } });
      await once(model, () => known() === '0,4');
      live.watchDemand(false);
      equal(false, made.heard.has('_world/demand'));
    },
    async 'a reset that comes before its kind is known leads to another scene'() {
      const made = new Made();
      const live = new Live(made, new Model(), new SimClock());
      made.tell('reset', { scope: 0 }, 0);
      await once(live, () => live.state === 'live');
      equal(2, made.scenes().length);
    },
    async 'the latest that is lost is asked for anew'() {
      const { made } = await begun();
      made.asked.length = 0;
      made.heard.get('_world/time/state').lose();
      made.heard.get('_world/info').lose();
      equal(['_world/time/state', '_world/info'], made.asked);
    },
    'paused, time ends where it was heard, even if it was shown to be later'() {
      const clock = new SimClock();
      clock.reset(6.5, 0);
      clock.setRate(1, false, 0);
      for (const wall of [100, 200, 300]) clock.receive(6.5 + wall / 1000, wall);
      clock.now(700);
      equal(true, clock.now(700) > 6.85);
      clock.setRate(1, true, 700);
      clock.receive(6.85, 710);
      for (let wall = 720; wall < 1200; wall += 16) {
        clock.receive(6.85, wall);
        clock.now(wall);
      }
      equal(6.85, clock.now(1200));
    },
    'time from which no more is heard stands where it was heard last'() {
      const clock = new SimClock();
      clock.reset(0, 0);
      clock.setRate(1, false, 0);
      clock.receive(2, 2000);
      for (let wall = 2000; wall < 4000; wall += 16) clock.now(wall);
      equal(2, clock.now(4000));
    },
    'the past is shown while the present goes on, up to which it is played'() {
      const { model, clock, rewind, hear, at } = driven();
      equal([8, 10], at());
      rewind.seek(3.5);
      equal([true, [3.5, 5]], [rewind.active, at()]);
      hear(8, { kind: 'teleported', entity: 'wall_e', at: [3, 3] });
      rewind.seek(1.5);
      equal([1.5, 1], at());
      equal([3, 3], rewind.head.robots.get('wall_e').poseAt(8).slice(0, 2));
      rewind.play();
      rewind.advance(1000);
      rewind.advance(2000);
      equal([2.5, 3], at());
      rewind.advance(60000);
      equal([false, [8, 3], 1], [rewind.active, at(), model.events.length]);
    },
    'another beginning leaves the past'() {
      const { clock, rewind, at } = driven();
      rewind.seek(2);
      clock.reset(0, 10);
      rewind.start(0);
      equal([false, 0, 0], [rewind.active, rewind.begin, at()[0]]);
    },
    'faults and failures are marks of the past, from which one returns to the present'() {
      const { rewind, hear } = driven();
      hear(4, { kind: 'fault_began', fault: 'slip', name: 'wet', robot: 'wall_e' });
      equal([4, 4], [rewind.jump(-1).t, rewind.time]);
      rewind.leave();
      rewind.seek(2);
      equal(['fault', 4], Object.values(rewind.jump(1)).slice(0, 2).reverse());
      equal([4, null], [rewind.time, rewind.jump(1)]);
      rewind.leave();
      equal(['wet'], [...rewind.head.faults.keys()]);
    },
    'only the latest past is kept'() {
      const { rewind, hear, clock, at } = driven();
      clock.receive(130, 20);
      for (let i = 0; i < 120; i += 1) {
        hear(9 + i, { robots: Array.from({ length: 1000 }, (_, k) => ({ name: `robot_${k}`, pose: [i, 0, 0] })) }, '_world/scene');
      }
      equal(true, rewind.begin > 9 && rewind.begin < 40);
      rewind.seek(0);
      equal(rewind.begin, at()[0]);
      equal([`${Math.round(rewind.begin - 9)}`], [`${rewind._model.robots.get('robot_7').poseAt(rewind.begin)[0]}`]);
    },
    'time that moves in bursts is never shown to go back'() {
      const clock = new SimClock();
      clock.reset(0, 0);
      const shown = [10, 50, 90, 300, 310, 500].map((wall) => {
        clock.receive(Math.floor(wall / 100), wall);
        return clock.now(wall + 5);
      });
      equal([...shown].sort((a, b) => a - b), shown);
      equal(5, clock.now(900));
    },
  };
  const wrong = {};
  for (const [claim, check] of Object.entries(claims)) {
    let timer;
    try {
      const late = new Promise((_, give) => (timer = setTimeout(() => give(new Error('never')), 15000)));
      await Promise.race([check(), late]);
    } catch (error) {
      wrong[claim] = String(error.stack ?? error);
    } finally {
      clearTimeout(timer); // node would wait for it
    }
  }
  return { claims: Object.keys(claims).length, wrong };
};
