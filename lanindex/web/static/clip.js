/** A stretch of a capture that plays, again and again, with its buttons. */

import { get, isAbort, problemOf } from "./api.js";
import { el, trouble } from "./dom.js";
import { Figure } from "./figure.js";
import { Motion } from "./motion.js";
import { Player, playerBar, playerKeys } from "./player.js";

const AROUND = 0.5; // seconds before and after it that are played, too

/**
 * Return the figure of a stretch; it ends with a signal.
 * @param {AbortSignal} signal
 * @param {{capture: string, capture_id: number, start: number, end: number, parts: Iterable<string>}} stretch parts: those that are lit
 * @param {string} [captures] where captures are
 */
export function clip(signal, { capture, capture_id: number, start, end, parts }, captures = "/api/captures") {
  const canvas = el("canvas", { class: "figure" }), root = el("div", { class: "clip" }, el("div", { class: "stage" }, canvas));
  open().catch((error) => {
    if (!isAbort(error)) root.replaceChildren(trouble(problemOf(error)));
  });
  return root;

  async function open() {
    const path = `${captures}/${number}`, description = await get(`${path}/figure`, signal);
    const figure = new Figure(canvas, { label: `A figure of ${capture}` });
    const motion = new Motion(path, description), player = new Player(motion, description.rate);
    const lit = new Set(parts), { strokes } = description, still = matchMedia("(prefers-reduced-motion: reduce)").matches;
    figure.floor = description.floor;
    motion.changed = () => player.refresh();
    player.listen((seconds) => {
      const pose = motion.pose(seconds), inside = start <= seconds && seconds <= end;
      if (pose) figure.show([{ strokes, pose, lit: inside ? lit : undefined }]);
    });
    player.range = [Math.max(start - AROUND, 0), Math.min(end + AROUND, motion.seconds)];
    player.loop = true;
    player.seek(start);
    if (!still) player.play();
    root.append(playerBar(player));
    playerKeys(root, player);
    signal.addEventListener("abort", () => {
      player.dispose();
      motion.abort();
      figure.dispose();
    });
  }
}
