/** The keys of all screens, as the help lists them: where, which, and what they do. */

/** @type {[string, [string, string][]][]} */
export const KEYS = [
  ["Everywhere", [
    ["Tab, Shift+Tab", "to the next control, or back"],
    ["Enter, Space", "press a button; Enter follows a link"],
  ]],
  ["Labels and columns in the library", [
    ["Enter", "change it; again: keep what was typed"],
    ["Tab", "keep it, and go to the next"],
    ["Esc", "leave it as it was"],
    ["Ctrl+Z", "undo"],
  ]],
  ["The line of a search", [
    ["\u2193, \u2191", "choose what is offered"],
    ["Tab, Enter", "take it"],
    ["Ctrl+Space", "offer what may stand here"],
    ["Enter", "search"],
    ["Esc", "offer nothing"],
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
  ["The sphere of cells", [
    ["\u2190, \u2192, \u2191, \u2193", "turn it"],
    ["0", "set it back"],
    ["Ctrl+Z", "undo a change of the numbers"],
  ]],
  ["Writing a score", [
    ["\u2190, \u2192, \u2191, \u2193", "another column, earlier, later"],
    ["Page Up, Page Down", "a bar later, a bar earlier"],
    ["Home, End", "to the starting position, to the end"],
    ["1 to 9", "a direction, as on a number pad: 8 forward, 5 place"],
    ["H, M, L", "high, middle, low"],
    ["[  ]", "fewer or more degrees"],
    ["Enter", "write the sign"],
    ["Delete", "take it away"],
    ["Shift+\u2191, Shift+\u2193", "end it later, earlier"],
    ["Shift+\u2190, Shift+\u2192", "begin it earlier, later"],
    ["Alt+\u2191, Alt+\u2193", "move it in time"],
    ["Alt+\u2190, Alt+\u2192", "move it to the next column of its kind"],
    ["Shift+M", "mirror it"],
    ["Ctrl+A, Ctrl+C, Ctrl+X, Ctrl+V", "choose all, copy, cut, paste"],
    ["Ctrl+Z, Ctrl+Y", "undo, do again"],
    ["Space", "play from here, pause"],
    ["+  \u2212", "faster, slower"],
    ["Esc", "choose nothing"],
  ]],
];
