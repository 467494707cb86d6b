/** What is chosen is spoken, by a voice of this machine: others would send the words elsewhere. */

import { announce } from "./dom.js";
import { toggle } from "./widgets.js";

const KEY = "lanindex-speech";

/** A button that turns it on and off; it stays as it was left. */
export class Speech {
  #on = localStorage.getItem(KEY) === "on";
  button = toggle((on) => this.#turn(on), this.#on, "Speak");

  constructor() {
    this.button.className = "speak";
    this.button.title = "Say aloud what is chosen on the staff";
    this.button.hidden = !("speechSynthesis" in window);
    if (this.button.hidden) this.#on = false;
    else speechSynthesis.getVoices(); // they come later
  }

  /** @param {boolean} on */
  #turn(on) {
    this.#on = on;
    localStorage.setItem(KEY, on ? "on" : "off");
    if (on) this.say("Symbols are spoken.");
    else speechSynthesis.cancel();
  }

  /** Say some English words in place of those before, if it is on. @param {string} words */
  say(words) {
    if (!this.#on) return;
    const voice = speechSynthesis.getVoices().find((it) => it.localService && it.lang.startsWith("en"));
    if (!voice) {
      announce("This machine has no English voice that a browser can use.");
      return;
    }
    speechSynthesis.cancel();
    const said = new SpeechSynthesisUtterance(words);
    said.voice = voice;
    speechSynthesis.speak(said);
  }
}
