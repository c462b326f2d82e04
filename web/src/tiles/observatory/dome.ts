/** A dome or a sliding roof: drawn, in words, and what it can be asked. */

import { css, html, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { base } from "../../elements/base.js";
import { formatAzimuth } from "../../format/sexagesimal.js";
import type { EnclosureInfo, SignalInfo } from "../../wire/api.js";
import { NO_DEVICE, Part, partStyle } from "./part.js";
import { domeDeeds, domeSignals, shutterOf, telescopeSignals, type DomeSignals, type ShutterState } from "./roles.js";
import "../../elements/observatory/dome-drawing.js";
import "../../elements/status.js";
import type { StatusKind } from "../../elements/status.js";
import "../command/command-card.js";
import "../command/deeds.js";
import "../signal-value.js";

const SAID: Readonly<Record<ShutterState, { kind: StatusKind; word: string }>> = {
  open: { kind: "warn", word: "Open" },
  closed: { kind: "ok", word: "Closed" },
  opening: { kind: "busy", word: "Opening" },
  closing: { kind: "busy", word: "Closing" },
  partial: { kind: "warn", word: "Partly open" },
  error: { kind: "bad", word: "In error" },
  unknown: { kind: "unknown", word: "Unknown" },
};

@customElement("t-part-dome")
export class DomePart extends Part {
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
    this.watch(...Object.values<SignalInfo | undefined>({ ...signals }), this.telescopeAzimuth(), ...this.sensors());
  }

  override render(): TemplateResult | typeof nothing {
    const { device } = this;
    if (device === null) return nothing;
    const signals = this.signals();
    const roof = this.roof(signals);
    const azimuth = this.known(signals.azimuth);
    const opening = this.known(signals.opening);
    const telescope = this.known(this.telescopeAzimuth());
    // Whoever sees only what is public is not told of what turns and what does not.
    const blind = signals.azimuth === undefined && !device.rights.includes("view");
    const { buttons, forms } = domeDeeds(device);
    return html`<section class="two" aria-label="Dome">
      <div class="card">
        <t-dome-drawing
          .roof=${roof}
          .azimuth=${azimuth.fresh ? azimuth.value : Number.NaN}
          .opening=${opening.fresh && roof !== "unknown" ? opening.value / 100 : Number.NaN}
          .telescope=${telescope.fresh ? telescope.value : Number.NaN}
          .turns=${signals.azimuth !== undefined || blind}
          .blind=${blind}
          ?turning=${this.isOn(signals.turning) === true}
        ></t-dome-drawing>
        ${signals.azimuth === undefined
          ? nothing
          : html`<p class="note">
              Seen from the south and from a little above; the plan beside it from straight above.${telescope.fresh ? " The line in the plan is where the telescope looks." : ""}
            </p>`}
      </div>
      <div class="card">
        <div class="head">
          <t-status class="big" kind=${SAID[roof].kind} .word=${SAID[roof].word}></t-status>
          ${signals.azimuth === undefined
            ? nothing
            : html`<span>looking to <strong>${azimuth.fresh ? formatAzimuth(azimuth.value) : "an unknown azimuth"}</strong></span>`}
        </div>
        ${this.proof(roof)}
        <div class="readings">
          ${map([signals.azimuth, signals.opening, signals.parked, signals.local], (signal) => this.reading(signal))}
        </div>
        ${this.lookOnly()}
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
    </section>`;
  }

  /** Parked is not closed, and neither is the command's success: the sensors say it. */
  private proof(roof: ShutterState): unknown {
    const enclosure = this.enclosure();
    if (enclosure === undefined) return nothing;
    const lines = enclosure.closed.map(({ signal, states }) => {
      const found = this.signalAt(signal);
      const { fresh, word } = this.known(found);
      return { name: found?.name ?? signal, word: fresh ? word : "unknown", closed: fresh && states.includes(word) };
    });
    const all = lines.every(({ closed }) => closed);
    const said = lines.map(({ name, word }) => `${name}: ${word}`).join(", ");
    if (all) return html`<t-status kind="ok" word="Every sensor says closed"></t-status>`;
    return html`<t-status
        kind=${roof === "closed" || roof === "unknown" ? "warn" : "unknown"}
        word=${roof === "closed" ? "Not every sensor says closed" : "Not closed by its sensors"}
      ></t-status>
      <p class="note">${said}</p>`;
  }

  private reading(signal: SignalInfo | undefined): unknown {
    return signal === undefined ? nothing : html`<t-signal-value size="m" .site=${this.site} .signal=${signal}></t-signal-value>`;
  }

  private signals(): DomeSignals {
    return domeSignals(this.device ?? NO_DEVICE);
  }

  private roof({ shutter }: DomeSignals): ShutterState {
    const now = this.known(shutter);
    return now.fresh ? shutterOf(now.word) : "unknown";
  }

  /** The roof that this device moves, if the description has one. */
  private enclosure(): EnclosureInfo | undefined {
    return this.detail?.enclosures.find(({ close }) => close.startsWith(`${this.device?.id ?? ""}/`));
  }

  private sensors(): readonly (SignalInfo | undefined)[] {
    return this.enclosure()?.closed.map(({ signal }) => this.signalAt(signal)) ?? [];
  }

  private signalAt(address: string): SignalInfo | undefined {
    return this.detail?.devices.flatMap(({ signals }) => signals).find((signal) => signal.address === address);
  }

  private telescopeAzimuth(): SignalInfo | undefined {
    const telescopes = this.detail?.devices.filter(({ kind }) => kind === "telescope") ?? [];
    return telescopes.length === 1 && telescopes[0] !== undefined ? telescopeSignals(telescopes[0]).az : undefined;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-part-dome": DomePart;
  }
}
