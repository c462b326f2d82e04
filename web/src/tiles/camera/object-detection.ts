/** What one camera's tile knows of objects: the person's choice, what was seen, and how the detector is. */

import { html, nothing, type LitElement } from "lit";
import { createRef, ref } from "lit/directives/ref.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import type { DetectorState, ObjectsOverlay } from "../../elements/camera/objects-overlay.js";
import "../../elements/camera/objects-overlay.js";
import type { ObjectsChoicePanel as ChoicePanel, WantedObjects } from "../../elements/camera/objects-choice.js";
import "../../elements/camera/objects-choice.js";
import type { CameraPictureBoxes, DetectedObject } from "../../generated/wire.js";
import { sessionContext } from "../../state/contexts.js";
import { AS_DESCRIBED, keepObjects, readObjects, type ObjectsChoice } from "../../state/objects-choice.js";
import { seesOnlyPublic } from "../../state/rights.js";
import { sitePath } from "../../state/router.js";
import { objectOptions, countObjects, framedObjects, minimumConfidence } from "./object-filter.js";
import type { DetectShape } from "../../generated/api.js";

/** A detector that says nothing for so long is silent (ms). */
const SILENT_MS = 3000;

/** Whose picture it is. */
export interface DetectionSubject {
  readonly site: string;
  readonly stream: string;
  readonly detects: DetectShape | null;
}

const NOTHING: readonly DetectedObject[] = [];

export class ObjectDetection {
  private subject: DetectionSubject = { site: "", stream: "", detects: null };
  private choice: ObjectsChoice = AS_DESCRIBED;
  private readFor = "";
  private classes = new Set<string>();
  private framedOf: readonly DetectedObject[] = NOTHING;
  private framedNow: readonly DetectedObject[] = NOTHING;
  private open = false;
  private readonly strip = createRef<ObjectsOverlay>();
  private readonly panel = createRef<ChoicePanel>();
  private readonly session;

  constructor(
    private readonly host: LitElement,
    private readonly notes: Pick<Storage, "getItem" | "setItem" | "removeItem"> | null,
  ) {
    this.session = new ContextStoreController(host, sessionContext);
  }

  /** Call it from `willUpdate`: what was chosen is read again for another person or camera. */
  setSubject(subject: DetectionSubject): void {
    const wanted = JSON.stringify([this.personId, subject.site, subject.stream]);
    this.subject = subject;
    if (wanted === this.readFor) return;
    this.readFor = wanted;
    this.classes = new Set();
    this.choice = readObjects(this.notes, this.personId, subject.site, subject.stream);
    this.refresh();
  }

  /** Boxes are wanted of the hub. */
  get isWanted(): boolean {
    return this.subject.detects !== null && this.choice.on;
  }

  receiveBoxes({ things }: CameraPictureBoxes): void {
    for (const { label } of things) this.classes.add(label);
  }

  /** What is framed of these things; the same list for the same things. */
  framedThings(things: readonly DetectedObject[]): readonly DetectedObject[] {
    const { detects } = this.subject;
    if (things !== this.framedOf) {
      this.framedOf = things;
      this.framedNow = detects === null || things.length === 0 ? NOTHING : framedObjects(things, this.choice, detects);
    }
    return this.framedNow;
  }

  /**
   * What lies over the picture.
   *
   * @param quiet - since when nothing has come from the detector (ms); null while nothing ever came
   */
  renderOverlay(things: readonly DetectedObject[], quiet: number | null, driving: boolean): unknown {
    const { detects } = this.subject;
    if (detects === null) return nothing;
    const detector: DetectorState = quiet === null ? "waiting" : quiet > SILENT_MS ? "silent" : "telling";
    return html`<t-objects
      slot="top"
      ${ref(this.strip)}
      ?on=${this.choice.on}
      detector=${detector}
      .counts=${countObjects(this.framedThings(things))}
      why=${this.logbookPath}
      ?busy=${driving}
      ?open=${this.open}
      @t-objects-switch=${this.onSwitch}
      @t-objects-open=${this.onOpened}
    ></t-objects>`;
  }

  /** What stands below it: never over a picture, and not while somebody drives by it. */
  renderBelow(driving: boolean): unknown {
    const { detects } = this.subject;
    if (driving || !this.isWanted) this.open = false;
    if (detects === null || !this.open) return nothing;
    return html`<t-objects-choice
      ${ref(this.panel)}
      .classes=${objectOptions(detects, this.classes, this.choice)}
      .confidence=${minimumConfidence(this.choice, detects)}
      .plain=${this.choice.classes === null && this.choice.confidence === null}
      @t-objects-want=${this.onObjectsChosen}
      @t-close=${this.onClosed}
    ></t-objects-choice>`;
  }

  private get logbookPath(): string {
    const person = this.session.store?.person;
    return person && !seesOnlyPublic(person) ? sitePath(this.subject.site, "logbook") : "";
  }

  private get personId(): string {
    return this.session.store?.person?.name ?? "";
  }

  private readonly onSwitch = (event: CustomEvent<boolean>): void => {
    this.saveChoice({ ...this.choice, on: event.detail });
  };

  private readonly onObjectsChosen = (event: CustomEvent<WantedObjects>): void => {
    this.saveChoice({ ...this.choice, ...event.detail });
  };

  private readonly onOpened = (event: CustomEvent<boolean>): void => {
    this.open = event.detail;
    this.host.requestUpdate();
    if (!this.open) return;
    void this.host.updateComplete.then(async () => {
      const panel = this.panel.value;
      await panel?.updateComplete;
      panel?.focus();
    });
  };

  private readonly onClosed = (): void => {
    this.open = false;
    this.host.requestUpdate();
    this.strip.value?.focus();
  };

  private saveChoice(choice: ObjectsChoice): void {
    this.choice = choice;
    keepObjects(this.notes, this.personId, this.subject.site, this.subject.stream, choice);
    this.refresh();
  }

  private refresh(): void {
    this.framedOf = this.framedNow = NOTHING;
    this.host.requestUpdate();
  }
}
