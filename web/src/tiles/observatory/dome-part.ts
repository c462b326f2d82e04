/** A dome or a sliding roof: drawn, in words, and what it can be asked. */

import { msg } from "@lit/localize";
import { css, html, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { base } from "../../elements/base/base-style.js";
import { formatAzimuth } from "../../format/sexagesimal.js";
import { shownText } from "../../format/unit.js";
import type { EnclosurePartShape, EnclosureShape, SightingShape, SignalShape } from "../../generated/api.js";
import { sensorsDisagree, type RoofSensor } from "./sensor-agreement.js";
import { NO_DEVICE, DevicePart, partStyle } from "./device-part.js";
import { domeCommands, domeSignals, shutterOf, telescopeSignals, type DomeSignals } from "./roles.js";
import type { RoofState } from "../../elements/observatory/dome-drawing.js";
import "../../elements/observatory/dome-drawing.js";
import "../../elements/feedback/status.js";
import type { StatusKind } from "../../elements/feedback/status.js";
import "../command/command-card.js";
import "../command/command-buttons.js";
import "../signal-value.js";

const SAID: Readonly<Record<RoofState, { kind: StatusKind; word: string }>> = {
  open: { kind: "warn", word: msg("Open", { id: "open.state" }) },
  closed: { kind: "ok", word: msg("Closed") },
  opening: { kind: "busy", word: msg("Opening") },
  closing: { kind: "busy", word: msg("Closing") },
  partial: { kind: "warn", word: msg("Partly open") },
  error: { kind: "bad", word: msg("In error") },
  unknown: { kind: "unknown", word: msg("Unknown") },
};

@customElement("t-part-dome")
export class DomePart extends DevicePart {
  static override styles = [
    base,
    partStyle,
    css`
      .big {
        font-size: var(--t-size-xl);
      }
      .head {
        display: flex;
        flex-wrap: wrap;
        align-items: baseline;
        gap: var(--t-space-1) var(--t-space-4);
      }
    `,
  ];

  override willUpdate(): void {
    const signals = this.signals();
    this.observeSignals(...Object.values<SignalShape | undefined>({ ...signals }), this.telescopeAzimuth(), ...this.sensorSignals());
  }

  override render(): TemplateResult | typeof nothing {
    const { device } = this;
    if (device === null) return nothing;
    const signals = this.signals();
    const roof = this.shutterState(signals);
    // Described as one that does not turn, it has no dial, whatever its device may say.
    const turns = signals.azimuth !== undefined && (this.enclosure()?.can.can_rotate ?? true);
    const azimuth = this.readSignal(turns ? signals.azimuth : undefined);
    const opening = this.readSignal(signals.opening);
    const telescope = this.readSignal(this.telescopeAzimuth());
    // Whoever sees only what is public is not told of what turns and what does not.
    const blind = signals.azimuth === undefined && !device.rights.includes("view");
    // One word of its controller is no proof, and is not shown as one.
    const judged = this.shutterVerdict();
    const doubted = roof === "closed" && judged !== undefined && !judged.closed;
    const { buttons, forms } = domeCommands(device);
    const drawing = html`<t-dome-drawing
      .roof=${roof}
      .azimuth=${azimuth.fresh ? azimuth.value : Number.NaN}
      .opening=${opening.fresh && roof !== "unknown" ? opening.value / 100 : Number.NaN}
      .telescope=${telescope.fresh ? telescope.value : Number.NaN}
      .turns=${turns || blind}
      .blind=${blind}
      .segments=${this.segmentOpenings()}
      ?turning=${this.isOn(signals.turning) === true}
    ></t-dome-drawing>`;
    const word = html`<t-status class="big" kind=${doubted ? "warn" : SAID[roof].kind} .word=${doubted ? msg("Says closed") : SAID[roof].word}></t-status>`;
    if (this.compact) return html`<div class="head" role="status">${word}</div>${drawing}${this.renderSensorProof(roof)}`;
    return html`<div class="two" role="group" aria-label=${msg("Dome")}>
      <div class="card">
        ${drawing}
        ${!turns
          ? nothing
          : html`<p class="note">
              ${telescope.fresh ? msg("Seen from the south and from a little above; the plan beside it from straight above. The line in the plan is where the telescope looks.") : msg("Seen from the south and from a little above; the plan beside it from straight above.")}
            </p>`}
      </div>
      <div class="card">
        <h2 class="visually-hidden">${msg("Shutter and rotation")}</h2>
        <div class="head">
          ${word}
          ${!turns
            ? nothing
            : html`<span>${msg(html`looking to <strong>${azimuth.fresh ? formatAzimuth(azimuth.value) : msg("an unknown azimuth")}</strong>`)}</span>`}
        </div>
        ${this.renderSensorProof(roof)}
        <div class="readings">
          ${map([turns ? signals.azimuth : undefined, signals.opening, ...this.segmentSignals(), signals.parked, signals.local], (signal) => this.renderReading(signal))}
        </div>
        ${this.renderLookOnly()}
        <t-deeds .site=${this.site} .device=${device} .line=${this.line} .deeds=${buttons} .online=${this.online}></t-deeds>
        ${map(
          forms,
          (command) => html`<t-command-card
            .site=${this.site}
            .device=${device}
            .command=${command}
            .line=${this.line}
            .online=${this.online}
          ></t-command-card>`,
        )}
      </div>
    </div>`;
  }

  /** Parked is not closed, and neither is the command's success: the sensors say it. */
  private renderSensorProof(roof: RoofState): unknown {
    const judged = this.shutterVerdict();
    if (judged === undefined) return nothing;
    if (judged.closed) return html`<t-status kind="ok" word=${msg("Every sensor says closed")}></t-status>`;
    if (judged.disagree) {
      return html`<t-status kind="bad" word=${msg("Its sensors disagree: it counts as not closed")}></t-status>
        <p class="note">${judged.said}</p>`;
    }
    return html`<t-status
        kind=${roof === "closed" || roof === "unknown" ? "warn" : "unknown"}
        word=${roof === "closed" ? msg("Not every sensor says closed") : msg("Not closed by its sensors")}
      ></t-status>
      <p class="note">${judged.said}</p>`;
  }

  /** What all its sensors say together; undefined where no enclosure is described. */
  private shutterVerdict(): { readonly closed: boolean; readonly disagree: boolean; readonly said: string } | undefined {
    const enclosure = this.enclosure();
    if (enclosure === undefined) return undefined;
    const [whole = [], ...segments] = [enclosure, ...enclosure.segments].map(({ closed }) => closed.map((sighting) => this.roofSensor(sighting)));
    const flap = enclosure.flap?.closed.map((sighting) => this.roofSensor(sighting)) ?? [];
    const lines = [...whole, ...segments.flat(), ...flap];
    return {
      closed: lines.every(({ closed }) => closed === true),
      disagree: sensorsDisagree(whole, segments, [flap]),
      said: lines.map(({ name, word }) => `${name}: ${word}`).join(", "),
    };
  }

  private roofSensor(sighting: SightingShape): RoofSensor {
    const found = this.signalAt(sighting.signal);
    const { fresh, word, value } = this.readSignal(found);
    const name = found?.name ?? sighting.signal;
    if (!fresh) return { name, word: msg("unknown"), closed: null };
    if (found?.type !== "number") return { name, word, closed: sighting.states.includes(word) };
    const inside = (sighting.above === null || value > sighting.above) && (sighting.below === null || value < sighting.below);
    return { name, word: shownText(found, value), closed: inside };
  }

  /** How far each segment is open, 0 to 1, west first; empty where it has none, or one does not say. */
  private segmentOpenings(): readonly number[] {
    const segments = this.enclosure()?.segments ?? [];
    return segments.map(({ position }) => {
      const { fresh, value } = this.readSignal(this.signalAt(position));
      return fresh ? value / 100 : Number.NaN;
    });
  }

  /** What says how far segments and flap are open. */
  private segmentSignals(): readonly (SignalShape | undefined)[] {
    const enclosure = this.enclosure();
    const parts = enclosure === undefined ? [] : partsOf(enclosure);
    const flap = enclosure?.flap?.position === "" ? enclosure.flap.closed.map(({ signal }) => signal) : [];
    return [...parts.map(({ position }) => position).filter((address) => address !== ""), ...flap].map((address) => this.signalAt(address));
  }

  private renderReading(signal: SignalShape | undefined): unknown {
    return signal === undefined ? nothing : html`<t-signal-value size="m" .site=${this.site} .signal=${signal}></t-signal-value>`;
  }

  private signals(): DomeSignals {
    return domeSignals(this.device ?? NO_DEVICE);
  }

  private shutterState({ shutter }: DomeSignals): RoofState {
    const now = this.readSignal(shutter);
    return now.fresh ? shutterOf(shutter, now.value) : "unknown";
  }

  /** The roof that this device moves, if the description has one. */
  private enclosure(): EnclosureShape | undefined {
    return this.detail?.enclosures.find(({ close }) => close.startsWith(`${this.device?.id ?? ""}/`));
  }

  private sensorSignals(): readonly (SignalShape | undefined)[] {
    const enclosure = this.enclosure();
    if (enclosure === undefined) return [];
    const all = [enclosure, ...partsOf(enclosure)];
    return [
      ...all.flatMap(({ closed }) => closed.map(({ signal }) => signal)),
      ...all.map(({ position }) => position).filter((address) => address !== ""),
    ].map((address) => this.signalAt(address));
  }

  private signalAt(address: string): SignalShape | undefined {
    return this.detail?.devices.flatMap(({ signals }) => signals).find((signal) => signal.address === address);
  }

  private telescopeAzimuth(): SignalShape | undefined {
    const telescopes = this.detail?.devices.filter(({ kind }) => kind === "telescope") ?? [];
    return telescopes.length === 1 && telescopes[0] !== undefined ? telescopeSignals(telescopes[0]).az : undefined;
  }
}

function partsOf({ segments, flap }: EnclosureShape): readonly EnclosurePartShape[] {
  return flap === null ? segments : [...segments, flap];
}

declare global {
  interface HTMLElementTagNameMap {
    "t-part-dome": DomePart;
  }
}
