/** What one camera's tile knows of models: which are drawn, what they told last, and how they are. */

import { html, nothing, type LitElement } from "lit";
import { ContextStoreController } from "../../controllers/context-store.js";
import "../../elements/camera/models-strip.js";
import type { LegendWord, ModelRow, ModelState } from "../../elements/camera/models-strip.js";
import { colourNumber, coveredClasses, layerWords, percentText, type PictureOverlay } from "../../elements/camera/overlay-layer.js";
import type { PictureModelShape } from "../../generated/api.js";
import type { CameraPictureOverlay } from "../../generated/wire.js";
import { sessionContext } from "../../state/contexts.js";
import { keepShownModels, readShownModels } from "../../state/objects-choice.js";
import { EARLIER_MS, LONGEST_MS, type Timed } from "./box-sync.js";

/** A model that says nothing for so long is silent (ms); one that is slower, for three of its pictures. */
const SILENT_MS = 3000;

interface ToldOverlay {
  readonly told: CameraPictureOverlay;
  /** When it came (ms). */
  readonly at: number;
}

const NONE: readonly PictureOverlay[] = [];

export class ModelOverlays {
  private models: readonly PictureModelShape[] = [];
  private subject = "";
  private site = "";
  private stream = "";
  private choice: Readonly<Record<string, boolean>> = {};
  private newest = new Map<string, ToldOverlay>();
  private drawn: readonly PictureOverlay[] = NONE;
  private readonly session;

  constructor(
    private readonly host: LitElement,
    private readonly notes: Pick<Storage, "getItem" | "setItem" | "removeItem"> | null,
  ) {
    this.session = new ContextStoreController(host, sessionContext);
  }

  /** Call it from `willUpdate`: what was chosen is read again for another person or camera. */
  setSubject(site: string, stream: string, models: readonly PictureModelShape[]): void {
    this.models = models;
    const subject = JSON.stringify([this.personId, site, stream]);
    if (subject === this.subject) return;
    [this.subject, this.site, this.stream] = [subject, site, stream];
    this.choice = readShownModels(this.notes, this.personId, site, stream);
    this.clearOverlays();
  }

  /** Overlays are wanted of the hub. */
  get isWanted(): boolean {
    return this.models.some((model) => this.isShown(model));
  }

  receiveOverlay(told: CameraPictureOverlay, now: number): void {
    this.newest.set(told.model, { told, at: now });
  }

  /** Nobody looks any more, or the camera is another. */
  clearOverlays(): void {
    this.newest.clear();
    this.drawn = NONE;
  }

  /**
   * What belongs on the picture that is shown; the same list while it is the same. What was told of
   * a picture that is a little earlier is faint, and of one that is longer ago nothing is drawn.
   */
  overlaysOn(shown: Timed | null, now: number, driving: boolean): readonly PictureOverlay[] {
    const found: PictureOverlay[] = [];
    for (const model of this.models) {
      const newest = this.newest.get(model.id);
      if (newest === undefined || shown === null || !this.isShown(model)) continue;
      const lag = Math.max((shown.time_us - newest.told.time_us) / 1000, now - newest.at);
      if (lag > this.longest(model, driving)) continue;
      found.push({ model, layer: newest.told.layer, earlier: newest.told.seq !== shown.seq && lag > EARLIER_MS });
    }
    const same =
      found.length === this.drawn.length &&
      found.every(({ layer, earlier }, at) => layer === this.drawn[at]?.layer && earlier === this.drawn[at].earlier);
    if (!same) this.drawn = found;
    return this.drawn;
  }

  /** What lies over the picture's upper edge: the switches, and what is told, in words. */
  renderStrip(now: number): unknown {
    if (this.models.length === 0) return nothing;
    const rows = this.models.map((model): ModelRow => {
      const newest = this.newest.get(model.id);
      const state = this.stateOf(model, newest, now);
      return { id: model.id, on: this.isShown(model), state, words: newest === undefined ? [] : legendWords(model, newest.told) };
    });
    return html`<t-models slot="top" .models=${rows} @t-model-switch=${this.onSwitch}></t-models>`;
  }

  private stateOf(model: PictureModelShape, newest: ToldOverlay | undefined, now: number): ModelState {
    if (newest === undefined) return "waiting";
    return now - newest.at > Math.max(SILENT_MS, 3000 / model.max_rate) ? "silent" : "telling";
  }

  /** A slow model's word holds until its next one; a driver never sees one that is old. */
  private longest(model: PictureModelShape, driving: boolean): number {
    return driving ? EARLIER_MS : Math.max(LONGEST_MS, 1500 / model.max_rate);
  }

  /** A map of depth covers the whole picture: it is drawn for whoever asks. */
  private isShown(model: PictureModelShape): boolean {
    return this.choice[model.id] ?? model.kind !== "depth";
  }

  private get personId(): string {
    return this.session.store?.person?.name ?? "";
  }

  private readonly onSwitch = (event: CustomEvent<string>): void => {
    const model = this.models.find(({ id }) => id === event.detail);
    if (model === undefined) return;
    this.choice = { ...this.choice, [model.id]: !this.isShown(model) };
    this.newest.delete(model.id);
    keepShownModels(this.notes, this.personId, this.site, this.stream, this.choice);
    this.host.requestUpdate();
  };
}

/** Colours are told with their names. */
function legendWords(model: PictureModelShape, { layer }: CameraPictureOverlay): LegendWord[] {
  if (model.kind !== "segmentation") return layerWords(model, layer).map((text) => ({ text, colour: 0 }));
  return coveredClasses(model, layer).map(({ number, name, share }) => ({ text: `${name} ${percentText(share)}`, colour: colourNumber(model, number) }));
}
