/** Everything to turn a camera with: lease, buttons to hold, speed, and its presets. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import type { CommandClient } from "../../controllers/drive/command-client.js";
import { capWords } from "../../controllers/drive/drive-messages.js";
import { isFinal } from "../../controllers/drive/command-machine.js";
import type { DriveSession } from "../../controllers/drive/drive-session.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { LiveValuesController } from "../../controllers/live-values.js";
import { StoreController } from "../../controllers/store-controller.js";
import { TickerController } from "../../controllers/ticker.js";
import { base, quietText } from "../../elements/base/base-style.js";
import type { HoldDetail } from "../../elements/drive/hold-event.js";
import { lockText } from "../../format/interlock-reason.js";
import { shownText } from "../../format/unit.js";
import type { DeviceShape } from "../../generated/api.js";
import { interlocksContext, reachContext } from "../../state/contexts.js";
import { renderLease } from "../drive/session-lease.js";
import { presetNames, ptzButtons, ptzParts, type PtzParts } from "./ptz-parts.js";
import "../../elements/drive/aim-pad.js";
import "../../elements/drive/speed-limit.js";
import "../../elements/feedback/status.js";
import "../../elements/forms/button.js";
import "../command/command-buttons.js";
import "../command/command-card.js";

const DRAW_EVERY_MS = 200;

@customElement("t-ptz-pad")
export class PtzPad extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        gap: var(--t-space-3);
      }
      h2 {
        font-size: var(--t-size-m);
      }
      section {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        gap: var(--t-space-3);
      }
      .trouble {
        color: var(--t-warn);
        font-weight: var(--t-weight-strong);
      }
      .trouble:empty {
        display: none;
      }
      .place {
        display: flex;
        flex-wrap: wrap;
        gap: 0 var(--t-space-4);
        margin: 0;
        font-variant-numeric: tabular-nums;
      }
      .note {
        ${quietText}
      }
    `,
  ];

  @property() site = "";
  @property({ attribute: false }) device: DeviceShape | null = null;
  /** Of who may turn it; null for who may only look. */
  @property({ attribute: false }) seat: DriveSession | null = null;
  @property({ attribute: false }) line: CommandClient | null = null;
  @property({ type: Boolean }) stopped = false;
  @property({ type: Boolean }) online = true;
  /** How old the picture is (ms); -1 for none. */
  @property({ attribute: false }) pictureAge: () => number = () => -1;

  private readonly interlocks = new ContextStoreController(this, interlocksContext, () => {
    this.seat?.followLock(this.lockReason);
  });
  private readonly reach = new ContextStoreController(this, reachContext);
  private readonly live = new LiveValuesController(this);
  private readonly watchedSeat = new StoreController(this);
  private readonly watchedLine = new StoreController(this);

  constructor() {
    super();
    new TickerController(this, DRAW_EVERY_MS);
  }

  override willUpdate(): void {
    this.watchedSeat.setStore(this.seat);
    this.watchedLine.setStore(this.line);
    this.seat?.followLock(this.lockReason);
    this.live.observeChannels(this.site, this.device?.signals.flatMap(({ channels }) => channels) ?? []);
  }

  override render(): TemplateResult | typeof nothing {
    const { device, seat } = this;
    if (device === null) return nothing;
    const away = this.reach.store?.unreachableSince(this.site, device.id);
    return html`${away === undefined
        ? nothing
        : html`<div role="status"><t-status kind="unknown" word=${msg("The camera does not answer")}></t-status> <span class="note">${away.why}</span></div>`}
      ${seat === null ? nothing : this.renderHands(device, seat, away !== undefined)} ${this.renderPlace(device)} ${this.renderPresets(device, away !== undefined)}`;
  }

  private renderHands(device: DeviceShape, seat: DriveSession, silent: boolean): TemplateResult {
    const { machine, lease, told } = seat;
    const mine = lease.state.kind === "mine";
    const refusal = mine && !this.stopped ? (told?.why ?? "") : "";
    const slow = mine && told !== null ? capWords(told.cap, told.loop_ms, this.pictureAge(), this.interlocks.store?.slowOf(this.site, device.id)?.name) : "";
    return html`${renderLease(seat, { stopped: this.stopped, forces: device.rights.includes("admin") })}
      <t-aim-pad
        .axes=${device.drive?.joints.map(({ id }) => id) ?? []}
        ?disabled=${!machine.mayDrive || silent}
        @t-hold=${this.onHold}
        @t-halt=${this.onHalt}
      ></t-aim-pad>
      <p class="trouble" role="alert">${this.lockReason || seat.problem || (refusal === "" ? "" : msg(str`Gateway: ${refusal}`))}</p>
      <t-speed-limit .level=${machine.speedLevel} means=${msg("of what is allowed")} @t-level=${this.onSpeedLevel}></t-speed-limit>
      ${slow === "" ? nothing : html`<p class="note">${slow}</p>`}
      <p class="note">${msg("It turns while a button or key is held: W A D X or the arrows, E and Q to zoom. S halts, Escape is STOP.")}</p>`;
  }

  private renderPlace(device: DeviceShape): unknown {
    const told = device.signals.filter(({ type, id }) => type === "number" && device.drive?.joints.some((joint) => joint.id === id) === true);
    if (told.length === 0) return nothing;
    return html`<dl class="place" aria-label=${msg("Where it looks")}>
      ${repeat(
        told,
        ({ id }) => id,
        (signal) => html`<div>${signal.name} <strong>${this.freshText(signal)}</strong></div>`,
      )}
    </dl>`;
  }

  private renderPresets(device: DeviceShape, silent: boolean): unknown {
    const parts = ptzParts(device);
    if (parts.goto === undefined && parts.home === undefined && parts.stop === undefined) return nothing;
    // What a silent camera had is not known to be there now.
    const names = silent ? null : this.namesOf(parts);
    return html`<section aria-label=${msg("Presets")}>
      <h2>${msg("Presets")}</h2>
      ${parts.goto !== undefined && parts.presets !== undefined && names !== null && names.length === 0 ? html`<p class="note">${msg("The camera has no presets yet.")}</p>` : nothing}
      ${names === null && parts.presets !== undefined ? html`<t-status kind="unknown" word=${msg("Its presets are not known now")}></t-status>` : nothing}
      ${device.rights.includes("use")
        ? html`<t-deeds .site=${this.site} .device=${device} .line=${this.line} .deeds=${ptzButtons(parts, names ?? [])} .online=${this.online && !silent}></t-deeds>
            ${this.renderCancel(device, parts)} ${this.renderForms(device, parts)}`
        : html`<p class="note">${msg(html`${names === null || names.length === 0 ? "" : `${names.join(", ")}. `}Turning this camera needs the right <strong>use</strong>; an admin can give it to you.`)}</p>`}
    </section>`;
  }

  /** A way to a preset that takes long can be ended. */
  private renderCancel(device: DeviceShape, { goto, home }: PtzParts): unknown {
    return [goto, home].map((command) => {
      const asked = command === undefined ? null : (this.line?.desk.latestRequest(device.id, command.id) ?? null);
      if (command === undefined || !command.cancellable || asked === null || isFinal(asked.phase)) return nothing;
      const cancel = (): void => {
        this.line?.cancelCommand(device.id, command.id);
      };
      return html`<t-button kind="danger" ?disabled=${!this.online} @click=${cancel}>${msg("Cancel:")} ${command.name}</t-button>`;
    });
  }

  private renderForms(device: DeviceShape, { keep, remove }: PtzParts): unknown {
    const forms = [keep, remove].filter((command) => command !== undefined);
    if (forms.length === 0) return nothing;
    return html`<details>
      <summary>${msg("Change presets")}</summary>
      ${repeat(
        forms,
        ({ id }) => id,
        (command) => html`<t-command-card .site=${this.site} .device=${device} .command=${command} .line=${this.line} .online=${this.online}></t-command-card>`,
      )}
    </details>`;
  }

  /** Null where they are not known. */
  private namesOf({ presets }: PtzParts): readonly string[] | null {
    const channel = presets?.channels[0];
    const text = channel === undefined ? null : (this.live.readingOf(channel)?.text ?? null);
    return text === null ? null : presetNames(text);
  }

  private freshText(signal: DeviceShape["signals"][number]): string {
    const channel = signal.channels[0];
    const fresh = this.online && channel !== undefined && this.live.freshnessOf(channel, signal.max_age) === "live";
    const value = fresh ? (this.live.readingOf(channel)?.value ?? Number.NaN) : Number.NaN;
    return Number.isNaN(value) ? msg("unknown") : shownText(signal, value);
  }

  private get lockReason(): string {
    const lock = this.device && this.interlocks.store?.lockOf(this.site, this.device.id, "drive");
    return lock ? lockText(lock) : "";
  }

  private readonly onHold = ({ detail: { act, source, stick, kind } }: CustomEvent<HoldDetail>): void => {
    if (act === "press") this.seat?.pressHold(source, stick, kind);
    else if (act === "release") this.seat?.releaseHold(source);
    else if (act === "cancel") this.seat?.cancelHold(source);
  };

  private readonly onHalt = (): void => {
    this.seat?.haltMotion("stop key");
  };

  private readonly onSpeedLevel = (event: CustomEvent<number>): void => {
    this.seat?.setLevel(event.detail);
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-ptz-pad": PtzPad;
  }
}
