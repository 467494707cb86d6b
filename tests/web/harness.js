import { Figure, figureBar, spaceDrawer } from "/static/figure.js";
import { Motion } from "/static/motion.js";
import { Player, playerBar, playerKeys } from "/static/player.js";
import { StaffView } from "/static/staff.js";

const policy = trustedTypes.createPolicy("svg", { createHTML: (text) => text });
const parse = (text) =>
  document.adoptNode(new DOMParser().parseFromString(policy.createHTML(text), "image/svg+xml").documentElement);

const path = "/api/captures/1";
const description = await (await fetch(`${path}/figure`)).json();
const motion = new Motion(path, description);
const player = new Player(motion, description.rate);
motion.changed = () => player.refresh();
const figure = new Figure(document.getElementById("figure"), { label: "A walker", space: await spaceDrawer() });
figure.floor = description.floor;
const log = [];
const said = { picked: [], selected: [] };
const staff = new StaffView(document.getElementById("staff"), {
  seconds: motion.seconds,
  load: async (from, to, zoom, signal) => {
    const answer = await fetch(`${path}/staff?from=${from}&to=${to}&zoom=${zoom}`, { signal });
    return answer.json();
  },
  parse,
  seek: (seconds) => player.seek(seconds),
  pick: (symbol) => said.picked.push(symbol.dataset.part),
  select: (range) => said.selected.push(range),
});
const state = { ghosts: false, lit: null };
player.listen((seconds) => {
  const pose = motion.pose(seconds);
  if (pose) {
    const ghosts = state.ghosts ? motion.around(seconds) : [];
    figure.show([{ strokes: description.strokes, pose, ghosts, lit: state.lit, way: motion.way(seconds) }]);
  }
  staff.show(seconds);
  if (pose) document.body.dataset.ready = "";
  log.push({ at: performance.now(), figure: pose ? seconds : null, staff: staff.time, drawn: figure.drawn });
});
document.getElementById("bars").append(playerBar(player), figureBar(figure, (on) => {
  state.ghosts = on;
  player.refresh();
}));
playerKeys(document.body, player);
Object.assign(window, { figure, motion, player, staff, log, said, state, description });
