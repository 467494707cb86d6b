/** The keys of all screens, as the help lists them: where, which, and what they do. */

/** @type {[string, [string, string][]][]} */
export const KEYS = [
  ["Everywhere", [
    ["Tab, Shift+Tab", "to the next control, or back"],
    ["Enter, Space", "press a button; Enter follows a link"],
  ]],
  ["What plays", [
    ["Space", "play, pause"],
    ["\u2190, \u2192", "a second back, a second on"],
    [",  .", "a frame back, a frame on"],
    ["L", "play the stretch again and again, or not"],
  ]],
  ["The figure", [
    ["\u2190, \u2192, \u2191, \u2193", "turn it"],
    ["+  \u2212", "larger, smaller"],
    ["0", "from the front again, all of it"],
  ]],
  ["The staff", [
    ["\u2191, \u2193", "later, earlier"],
    ["Shift+\u2191, Shift+\u2193", "select a stretch"],
    ["\u2190, \u2192", "choose a symbol of this time"],
    ["Enter", "take the chosen symbol"],
    ["+  \u2212", "larger, smaller"],
    ["Esc", "select nothing"],
  ]],
];
