// Parts of the replay page, worked out by hand.

import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "./load.mjs";

const { Story, Heat, Player, Steps, signsOf } = load("replay", ["01-unpack", "03-story", "04-counts", "11-heat", "15-player", "18-legend"], [
  "Story", "Heat", "Player", "Steps", "signsOf",
]);

// A story in which robots wait for others: `now` has for each robot the one that it waits for (-1: nobody), or null.
function waiting(now) {
  const story = Object.create(Story.prototype);
  story.waitOther = now;
  story.waiting = (robot) => (now[robot] === null ? -1 : robot);
  return story;
}

const chain = (now, robot) => {
  const { waits, last, ring } = waiting(now).chain(robot, 0);
  return [Array.from(waits), last, ring];
};

test("a chain is followed to the robot that waits for no other", () => {
  assert.deepEqual(chain([1, 2, null], 0), [[0, 1], 2, false]);
  assert.deepEqual(chain([1, 2, null], 2), [[], 2, false]);
});

test("a chain ends where somebody waits for no robot", () => {
  assert.deepEqual(chain([1, -1], 0), [[0, 1], -1, false]);
});

test("robots that wait for each other are a ring", () => {
  assert.deepEqual(chain([1, 2, 1], 0), [[0, 1, 2], 1, true]);
});

test("time lost is counted from the warm-up on, as a part of the window, on a fixed scale", () => {
  const story = { waitTime: [5, 20, 40], waitBegin: [0, 8, 38], waitEdge: [0, 0, 1], from: 10 };
  const heat = new Heat(story, { real: 2 }, [0.01, 0.05, 0.2], 110);
  assert.deepEqual(Array.from(heat.shares), [0.1, 0.02]); // the first was over, of the second 10 of 12 count
  assert.deepEqual(JSON.parse(JSON.stringify(heat.shaded)), [[1], [0], []]);
});

function side(begin, end, wide, fastest) {
  const header = { start: 0, end, begin, tick: 1, fastest, radii: [0.5], units: { time: "s", seconds: 1 } };
  return { header, span: end, view: { bounds: { left: 0, right: wide, top: 0, bottom: 1 } } };
}

test("it opens at the end of the warm-up, and a robot crosses the floor in eight seconds", () => {
  const player = new Player([side(3600, 18000, 60, 1.5)]);
  assert.equal(player.time, 3600);
  assert.equal(player.whole, true);
  assert.equal(player.speed, 5); // 60 m at 1.5 m/s are 40 s
  assert.equal(player.day(), 300);
  const named = Array.from(player.speeds, ({ words }) => words).filter((words) => /watch|minute/.test(words));
  assert.deepEqual(named, ["5×, watch", "300×, all in a minute"]);
});

test("it does not blur at the speed to watch at, and does where all is played in a minute", () => {
  const player = new Player([side(0, 18000, 60, 1.5)]);
  player.toggle();
  assert.equal(player.blurs, false);
  player.speed = player.day();
  assert.equal(player.blurs, true);
  player.seek(10);
  assert.equal(player.whole, false);
});

test("a curve of steps stays as it is until the next", () => {
  const steps = new Steps([2, 5], [1, 7], NaN);
  assert.deepEqual([1, 2, 4, 5, 9].map((time) => steps.at(time)), [NaN, 1, 1, 7, 7]);
});

test("a role that few models have is in the legend of a page that has it, once, in the words of its state", () => {
  const side = (...roles) => ({
    header: { capacity: null, states: roles.map((role) => ({ role, doing: `is ${role}` })), two_way: [] },
    scene: { floor: { cell: false, zones: [] } },
    story: { shutVisit: [] },
  });
  const told = (...sides) => Array.from(signsOf(sides)).filter(([, words]) => words.startsWith("is ")).map(([sign]) => sign);
  assert.deepEqual(told(side("idle", "empty", "loaded", "wait")), []);
  assert.deepEqual(told(side("idle", "broken"), side("broken", "broken", "down")), ["broken", "down"]);
});
