// For tests and other scripts on the page. Times are the first run's; `ready` is resolved when the page is ready.

function hook(app) {
  const { player, sides } = app;
  const seek = (time) => {
    player.seek(time);
    app.show();
  };
  return {
    ...about(app, sides[0], seek), player, seek, time: () => player.time,
    beside: sides.length > 1 ? about(app, sides[1], seek) : null,
    frames: () => ({ count: app.frames, drawing: app.drawing }),
    picture: () => app.picture.draw().toDataURL("image/png"),
  };
}

// What can be asked of one run.
function about(app, side, seek) {
  const { header, scene, tracks, story, view, heat } = side, now = () => app.player.in(side);
  return {
    header,
    // Where the robots are at a time (world units), by moving the page there.
    positions: (time) => {
      seek(time);
      return Array.from(tracks.x, (x, i) => [x, tracks.y[i]]);
    },
    drawn: () => Array.from(tracks.x, (x, i) => [x * view.scale + view.x, tracks.y[i] * view.scale + view.y]),
    radii: () => header.radii.map((_, robot) => scene.radius(robot)),
    scale: () => view.scale,
    screen: (x, y) => [x * view.scale + view.x, y * view.scale + view.y],
    waiting: () => Array.from(scene.wait.keys()).filter((robot) => story.waiting(robot, now()) >= 0),
    // Closed edges, and those with people in them, now: source, target, and whether it is a person.
    blocked: () => story.blocked(now()).map((i) => [scene.edges.source[story.shutEdge[i]], scene.edges.target[story.shutEdge[i]]].map((node) => side.name(node)).concat(story.shutVisit[i] >= 0)),
    states: () => Array.from(scene.mood, (state) => header.states[state].name),
    chosen: () => scene.chosen,
    route: () => scene.ahead(now()).nodes.map((node) => side.name(node)),
    tiles: () => Object.fromEntries(header.tiles.map(([key, , form]) => [key, side.value(key, form, now())])),
    resources: () => side.resources.map((one) => ({ kind: one.kind, node: side.name(one.node), queue: one.queue.at(now()), utilisation: one.utilisation(now()) })),
    deliveredAt: () => Object.fromEntries(Array.from(story.deliveries.keys(), (node) => [side.name(node), story.deliveredAt(node, now())])),
    directions: () => scene.directions().map((edge) => [scene.edges.source[edge], scene.edges.target[edge]].map((node) => side.name(node))),
    // The part of the time in which robots waited at the end of each edge.
    heat: () => Array.from(heat.shares),
  };
}

async function begin() {
  const page = JSON.parse(byId("header").textContent);
  const texts = Array.from(document.querySelectorAll("script.columns"));
  const columns = await Promise.all(page.runs.map((header, i) => columnsOf(header.columns, texts[i].textContent.trim())));
  for (const text of texts) text.remove();
  const app = new App(page, columns);
  Object.assign(window.desimReplay, hook(app));
  app.show(); // with its words in place, the page has its size
  app.resized();
  app.show();
  return performance.now();
}

window.desimReplay = {};
window.desimReplay.ready = begin().catch((error) => {
  const problem = byId("problem");
  problem.hidden = false;
  problem.textContent = `This replay cannot be shown: ${error.message}. It needs a browser of 2023 or later.`;
  throw error;
});
