// Pickers of the replay page, worked out by hand.

import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "./load.mjs";

const { People, Edges, FREE, WALKS, PICKS } = load("replay", ["01-unpack", "02-tracks", "09-scene", "10-people"],
  ["People", "Edges", "FREE", "WALKS", "PICKS"]);
const plain = (value) => JSON.parse(JSON.stringify(value));

// A lane of 10 from A to B and one of 10 from B up to C. Picker 0 begins at 4, walks by B to 6 on the second from 10 to 22,
// is there before robot 3, which comes at 30, and picks until 35. Picker 1 stays at C.
const header = {
  grain: 0.1, real: 2, source: [0, 1], target: [1, 2], length: [10, 10], two_way: [], radii: [1, 1, 1, 1], places: [],
  nodes: [["A", 0, 0], ["B", 10, 0], ["C", 10, 10]],
};
const people = () => new People({
  picker_edge: [0, -3], picker_at: [40, 0], act_count: [2, 0], act_time: [10, 20], act_length: [12, 5], act_robot: [3, 3],
  act_nodes: [1, -1], act_node: [1], act_edge: [1], act_at: [60],
}, new Edges(header), header);

test("a picker walks past nodes at an even pace, and stays where he was sent", () => {
  const some = people(), tracks = { count: 4, x: [], y: [] };
  const at = (time) => {
    some.place(time, tracks);
    return [tracks.x[4], tracks.y[4]];
  };
  assert.deepEqual([0, 10, 13, 16, 19, 22, 50, 13].map(at), [[4, 0], [4, 0], [7, 0], [10, 0], [10, 3], [10, 6], [10, 6], [7, 0]]);
  assert.deepEqual([tracks.x[5], tracks.y[5]], [10, 10]);
});

test("he walks, is there before the robot, picks, and is free", () => {
  const does = (time) => [people().doing(0, time).does, people().doing(0, time).robot];
  assert.deepEqual([5, 10, 22, 30, 35].map(does), [[FREE, -1], [WALKS, 3], [FREE, 3], [PICKS, 3], [FREE, -1]]);
  assert.deepEqual(plain(people().doing(1, 50)), { does: FREE, robot: -1, until: null });
});

test("a robot knows who comes", () => {
  assert.deepEqual([5, 12, 31, 40].map((time) => people().with(3, time)), [-1, 0, 0, -1]);
});

test("the rest of a way is what is drawn before him", () => {
  assert.deepEqual(plain(people().ahead(0, 13)), [[7, 0], [10, 0], [10, 6]]);
});

test("pages without pickers have none", () => {
  assert.equal(new People({}, new Edges(header), header).count, 0);
});
