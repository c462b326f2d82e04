import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { base } from "../../elements/base/base-style.js";
import { isObject, type Json, type JsonObject } from "./json-schema.js";

/** How devices will look: their signals as tiles without values, their commands by name. */
@customElement("t-description-preview")
export class DescriptionPreview extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        gap: var(--t-space-3);
      }
      section {
        display: grid;
        gap: var(--t-space-2);
        padding: var(--t-space-3);
        border: 1px dashed var(--t-edge);
        border-radius: var(--t-radius-s);
      }
      h3 {
        margin: 0;
        font-size: var(--t-size-m);
      }
      .tiles {
        display: grid;
        grid-template-columns: repeat(auto-fill, minmax(9rem, 1fr));
        gap: var(--t-space-2);
      }
      .tile {
        display: grid;
        padding: var(--t-space-2) var(--t-space-3);
        border-radius: var(--t-radius-s);
        background: var(--t-raised);
        overflow-wrap: anywhere;
      }
      .tile b {
        font-size: var(--t-size-l);
      }
    `,
  ];

  @property({ attribute: false }) described: JsonObject = {};
  /** Which devices; all others are left out. */
  @property({ attribute: false }) devices: readonly string[] = [];

  override render(): TemplateResult {
    const all = this.described["devices"];
    const shown = this.devices.flatMap((name) => {
      const device = isObject(all) ? all[name] : undefined;
      return isObject(device) ? [device] : [];
    });
    if (shown.length === 0) return html`<p class="muted small">${msg("No device's page changes.")}</p>`;
    return html`${map(shown, (device) => this.renderDevice(device))}`;
  }

  private renderDevice(device: JsonObject): TemplateResult {
    const commands = objectsOf(device["commands"]).map((command) => textOf(command["name"]));
    return html`<section aria-label=${msg(str`Preview of ${textOf(device["name"])}`)}>
      <h3>${textOf(device["name"])}</h3>
      <div class="tiles">
        ${map(
          objectsOf(device["signals"]),
          (signal) => html`<div class="tile">
            <span>${textOf(signal["name"])}</span><b>— <span class="muted small">${textOf(signal["unit"])}</span></b
            ><span class="muted small">${signal["primary"] === false ? msg("among the details") : rangeText(signal)}</span>
          </div>`,
        )}
        ${map(objectsOf(device["streams"]), (stream) => html`<div class="tile"><span>${textOf(stream["name"])}</span><span class="muted small">${msg("camera")}</span></div>`)}
      </div>
      ${commands.length === 0 ? nothing : html`<p class="muted small">${msg("Commands:")} ${commands.join(", ")}</p>`}
    </section>`;
  }
}

function objectsOf(value: Json | undefined): JsonObject[] {
  return isObject(value) ? Object.values(value).filter(isObject) : [];
}

function textOf(value: Json | undefined): string {
  return typeof value === "string" ? value : "";
}

function rangeText(signal: JsonObject): string {
  const { minimum, maximum } = signal;
  const low = typeof minimum === "number" ? String(minimum) : "";
  const high = typeof maximum === "number" ? String(maximum) : "";
  return low === "" && high === "" ? "" : msg(str`${low} to ${high}`);
}

declare global {
  interface HTMLElementTagNameMap {
    "t-description-preview": DescriptionPreview;
  }
}
