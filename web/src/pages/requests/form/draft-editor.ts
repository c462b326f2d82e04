/** What a person does to a draft: types in it, adds and removes rows, chooses which of its requests is shown. */

import type { ReactiveController, ReactiveControllerHost } from "lit";
import type { GroupShape } from "../../../generated/api.js";
import { clockOf, DAY_US, HOUR_US } from "../../../series/zone-clock.js";
import type { Mosaic } from "../../../sky/mosaic.js";
import type { SkyPoint } from "../../../sky/tangent-plane.js";
import { readCadence, visitsOf, type CadenceDraft, type ReadCadence } from "./cadence.js";
import { NEW_FRAMES, newGroup, newRequest, replaceRequest, swapRequests, writeField, writeRequest, type GroupDraft, type RequestDraft, type WindowDraft } from "./draft.js";
import { draftOf, windowDraft, withZone } from "./fill-draft.js";
import { openedParts, type OpenedParts } from "./form-view.js";
import { panelRequests, placeTexts } from "./framing-draft.js";

/** A window of a new request lasts so long. */
const WINDOW_US = 30 * DAY_US;
const CADENCE_FIELD = /^cadence\.(first|every|within|visits)$/;
const SHOWN_REQUEST = ".requests [pressed=true]";

export class DraftEditor implements ReactiveController {
  draft: GroupDraft;
  /** Which request of the group is shown. */
  at = 0;
  opened: OpenedParts = { motion: false, phase: false };
  cadence: CadenceDraft = { first: "", every: "24", within: "2", visits: "7" };
  cadenceTried = false;
  /** As it was before the panels of a mosaic were made; null: none were. */
  beforePanels: { readonly draft: GroupDraft; readonly at: number } | null = null;
  private zone = "UTC";

  /**
   * @param focus shows whoever came by keyboard where something has changed, by its selector
   * @param onShow another request is shown
   */
  constructor(
    private readonly host: ReactiveControllerHost,
    private readonly focus: (selector: string) => void,
    private readonly onShow: () => void,
  ) {
    this.draft = newGroup("", { start: "", end: "", startUs: null, endUs: null });
    host.addController(this);
  }

  hostConnected(): void {
    this.cadenceTried = false;
  }

  /**
   * Begins with a new request.
   *
   * @param nowUs when its window opens
   */
  begin(proposal: string, zone: string, nowUs: number): void {
    this.fill(zone, nowUs, () => newGroup(proposal, this.windowFrom(nowUs, WINDOW_US)));
  }

  /** Begins with what is kept. */
  open(group: GroupShape, zone: string, nowUs: number): void {
    this.fill(zone, nowUs, () => draftOf(group, this.textOf));
  }

  private fill(zone: string, nowUs: number, make: () => GroupDraft): void {
    this.zone = zone;
    this.beforePanels = null;
    this.draft = make();
    this.cadence = { ...this.cadence, first: this.textOf(nowUs + DAY_US).slice(0, 16) };
    this.show(0);
  }

  /** Shows what is kept by another clock; what was typed stays as it is. */
  setZone(zone: string): void {
    this.zone = zone;
    this.change(withZone(this.draft, this.textOf));
  }

  readonly textOf = (us: number): string => clockOf(this.zone).toInput(us);
  readonly momentOf = (text: string): number => clockOf(this.zone).fromInput(text);

  /** Undefined only in a group without requests, which no form makes. */
  get request(): RequestDraft | undefined {
    return this.draft.requests[this.at];
  }

  get readCadence(): ReadCadence {
    return readCadence(this.cadence, this.momentOf, this.draft.requests.length - 1);
  }

  /** Another request of the group is shown. */
  show(at: number): void {
    this.at = Math.max(0, Math.min(this.draft.requests.length - 1, at));
    if (this.request !== undefined) this.opened = openedParts(this.request);
    this.onShow();
    this.host.requestUpdate();
  }

  changeRequest(change: Partial<RequestDraft>): void {
    this.change(writeRequest(this.draft, this.at, change));
  }

  readonly onInput = (event: Event): void => {
    const field = event.target;
    if (!(field instanceof HTMLInputElement || field instanceof HTMLSelectElement)) return;
    const cadence = CADENCE_FIELD.exec(field.name)?.[1];
    if (cadence !== undefined) this.cadence = { ...this.cadence, [cadence]: field.value };
    this.change(cadence === undefined ? writeField(this.draft, this.at, field.name, field.value) : this.draft);
  };

  /** A request of the same windows, with another target. */
  readonly addRequest = (): void => {
    const windows = this.request?.windows ?? [];
    const [first = this.windowFrom(Date.now() * 1000, WINDOW_US)] = windows;
    const many = this.draft.requests.length;
    this.change(replaceRequest(this.draft, many, [{ ...newRequest(first), windows }]));
    this.show(many);
    this.focus("[name=target]");
  };

  readonly copyRequest = (): void => {
    const { request, at } = this;
    if (request === undefined) return;
    this.change(replaceRequest(this.draft, at, [request, request]));
    this.show(at + 1);
    this.focus("[name=way]");
  };

  readonly removeRequest = (): void => {
    if (this.draft.requests.length < 2) return;
    this.change(replaceRequest(this.draft, this.at, []));
    this.show(this.at);
    this.focus(`${SHOWN_REQUEST}, [name=way]`);
  };

  readonly moveEarlier = (): void => {
    this.moveRequest(-1);
  };

  readonly moveLater = (): void => {
    this.moveRequest(1);
  };

  private moveRequest(by: -1 | 1): void {
    this.change(swapRequests(this.draft, this.at, this.at + by));
    this.show(this.at + by);
  }

  readonly addFrames = (): void => {
    const frames = this.request?.frames ?? [];
    this.changeRequest({ frames: [...frames, frames.at(-1) ?? NEW_FRAMES] });
    this.focus(`[name="type-${String(frames.length)}"]`);
  };

  readonly removeFrames = (row: number): void => {
    this.changeRequest({ frames: (this.request?.frames ?? []).filter((_, i) => i !== row) });
    this.focus(`[name="type-${String(Math.max(0, row - 1))}"]`);
  };

  /** The next one begins a day after the last ends, and lasts as long. */
  readonly addWindow = (): void => {
    const windows = this.request?.windows ?? [];
    const last = windows.at(-1);
    const [start, end] = last === undefined ? [Number.NaN, Number.NaN] : [last.startUs ?? this.momentOf(last.start), last.endUs ?? this.momentOf(last.end)];
    const next = end > start ? this.windowFrom(end + DAY_US, end - start) : this.windowFrom(Date.now() * 1000, 12 * HOUR_US);
    this.changeRequest({ windows: [...windows, next] });
    this.focus(`[name="start-${String(windows.length)}"]`);
  };

  readonly removeWindow = (row: number): void => {
    this.changeRequest({ windows: (this.request?.windows ?? []).filter((_, i) => i !== row) });
    this.focus(`[name="start-${String(Math.max(0, row - 1))}"]`);
  };

  /** In the place of the request stand its visits. */
  readonly makeVisits = (): void => {
    const { request, at, readCadence: cadence } = this;
    this.cadenceTried = true;
    if (request !== undefined && cadence.windows.length > 0) {
      this.change(replaceRequest(this.draft, at, visitsOf(request, cadence, this.textOf)));
      this.show(at);
      this.focus(SHOWN_REQUEST);
    }
    this.host.requestUpdate();
  };

  moveTarget(centre: SkyPoint): void {
    this.changeRequest(placeTexts(centre));
  }

  /** In the place of the request stand the panels of its mosaic. */
  makePanels(mosaic: Mosaic, rotates: boolean): void {
    const { request, at, draft } = this;
    if (request === undefined) return;
    this.beforePanels = { draft, at };
    this.change(replaceRequest(draft, at, panelRequests(request, mosaic, rotates)));
    this.show(at);
    this.focus(SHOWN_REQUEST);
  }

  readonly undoPanels = (): void => {
    if (this.beforePanels === null) return;
    const { draft, at } = this.beforePanels;
    this.beforePanels = null;
    this.change(draft);
    this.show(at);
    this.focus(`${SHOWN_REQUEST}, [name=way]`);
  };

  private windowFrom(startUs: number, lasts: number): WindowDraft {
    return windowDraft({ start_us: startUs, end_us: startUs + lasts }, this.textOf);
  }

  private change(draft: GroupDraft): void {
    this.draft = draft;
    this.host.requestUpdate();
  }
}
