// Floors and lifts on the replay page, worked out by hand.

import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "./load.mjs";

const { Edges, Tracks, Floor } = load("replay", ["01-unpack", "02-tracks", "07-floor", "09-lifts"], ["Edges", "Tracks", "Floor"]);

const plain = (value) => JSON.parse(JSON.stringify(value));

// A hall and the node of a lift downstairs, another upstairs with a ward: the lane to the cabin, the ride, the lane on.
const header = {
  nodes: [["hall", 0, 0], ["lift0", 10, 0], ["lift1", 10, 30], ["ward", 0, 30]],
  source: [0, 1, 2, 2], target: [1, 2, 3, 1], length: [10, 0, 10, 0], real: 4, two_way: [], places: [],
  radii: [0.5], aisle: 0, floors: [0, 0, 1, 1], floor_titles: ["floor 0", "wards"], lifts: [["main", [1, 2]]], zones: [], resources: [],
};
const edges = new Edges(header);

function floor(more = {}) {
  return Object.assign(Object.create(Floor.prototype), { header, edges, radius: 0.5, zones: [], ...more });
}

test("a robot in a cabin is on its way between the floors as long as the ride takes", () => {
  const tracks = Object.create(Tracks.prototype);
  Object.assign(tracks, { edges, count: 1, first: [0, 3], cursor: [0], begin: [0, 10, 30], end: [10, 30, 40], edge: [0, 1, 2],
    origin: [0, 0, 0], target: [10, 0, 10], on: [0], at: [0], x: [0], y: [0], heading: [0], moves: [0] });
  const places = [5, 10, 20, 29.5, 35].map((time) => {
    tracks.place(time);
    return [tracks.x[0], tracks.y[0]];
  });
  assert.deepEqual(places, [[5, 0], [10, 0], [10, 15], [10, 29.25], [5, 30]]);
});

test("rides are no lanes", () => {
  assert.deepEqual([-1, 0, 1, 2, 3, 4].map((edge) => floor().isRide(edge)), [false, false, true, false, true, false]);
});

test("each floor has a box round its nodes and what is beside them, from the lowest up", () => {
  const zones = [{ node: 3, left: -5, top: 29, right: -2, bottom: 33 }];
  assert.deepEqual(plain(floor({ zones }).levels()), [
    { name: "floor 0", left: -1.25, top: -1.25, right: 11.25, bottom: 1.25 },
    { name: "wards", left: -5, top: 28.75, right: 11.25, bottom: 33 },
  ]);
});

test("who waits for the lift or its cabin queues before a node of it, who rides does not", () => {
  // before lift0 for another robot (no edge) and for the cabin (on the lane to it), in the cabin, before the hall
  const story = { waitNode: [1, 1, 2, 0], waitEdge: [-1, 0, 1, -1] };
  assert.deepEqual(plain([...floor().queuing(story, [0, 1, 2, 3])]), [[1, 2]]);
  assert.deepEqual([...floor().queuing(story, [2, 3])], []);
});
