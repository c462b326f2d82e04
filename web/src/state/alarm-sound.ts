/** The sound of alarms: off until a person of this browser switches it on, by a click or a key. */

import { Store } from "./store.js";

const KEY = "talaia-alarm-sound";

/** What is needed of a browser's audio. */
export interface Beeper {
  beep(): void;
}

/** Two short tones, made without a file. */
export class ToneBeeper implements Beeper {
  private context: AudioContext | null = null;

  beep(): void {
    this.context ??= new AudioContext();
    const { context } = this;
    void context.resume();
    for (const [at, pitch] of [
      [0, 880],
      [0.22, 660],
    ] as const) {
      const tone = context.createOscillator();
      const volume = context.createGain();
      tone.frequency.value = pitch;
      volume.gain.value = 0.15;
      tone.connect(volume).connect(context.destination);
      tone.start(context.currentTime + at);
      tone.stop(context.currentTime + at + 0.18);
    }
  }
}

export class AlarmSound extends Store {
  private heard = 0;
  /** Browsers are silent until somebody has touched the page. */
  private touched = false;

  constructor(
    private readonly storage: Pick<Storage, "getItem" | "setItem"> | null,
    private readonly beeper: Beeper = new ToneBeeper(),
  ) {
    super();
  }

  get isOn(): boolean {
    return this.storage?.getItem(KEY) === "on";
  }

  /** Whether it is switched on and will be heard. */
  get isAudible(): boolean {
    return this.isOn && this.touched;
  }

  /** Call it from a click or a key: that is what lets a page make a sound. */
  setOn(on: boolean): void {
    this.touched = true;
    this.storage?.setItem(KEY, on ? "on" : "off");
    if (on) this.beeper.beep();
    this.notifyWatchers();
  }

  /** Somebody has touched the page. */
  unlockAudio(): void {
    if (this.touched) return;
    this.touched = true;
    this.notifyWatchers();
  }

  /** Makes a sound if more alarms have been raised than were heard. */
  soundIfMore(raised: number): void {
    const more = raised > this.heard;
    this.heard = raised;
    if (more && this.isAudible) this.beeper.beep();
  }
}
