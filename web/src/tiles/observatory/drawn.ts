/** The drawn part of a device's page, chosen by what the device is. */

import { html, nothing, type TemplateResult } from "lit";
import type { CommandClient } from "../../controllers/drive/command-client.js";
import type { DeviceInfo, SiteDetail } from "../../wire/api-types.js";
import { partOf } from "./roles.js";
import "./camera-part.js";
import "./dome-part.js";
import "./power-part.js";
import "./telescope-part.js";
import "./weather-part.js";

export interface DrawnPartOptions {
  readonly site: string;
  readonly device: DeviceInfo;
  readonly detail: SiteDetail;
  readonly line: CommandClient | null;
  readonly online: boolean;
}

/** Nothing for a device that has none: its values and commands say it all. */
export function renderDrawnPart({ site, device, detail, line, online }: DrawnPartOptions): TemplateResult | typeof nothing {
  switch (partOf(device)) {
    case "dome":
      return html`<t-part-dome .site=${site} .device=${device} .detail=${detail} .line=${line} .online=${online}></t-part-dome>`;
    case "telescope":
      return html`<t-part-telescope .site=${site} .device=${device} .detail=${detail} .line=${line} .online=${online}></t-part-telescope>`;
    case "weather":
      return html`<t-part-weather .site=${site} .device=${device} .detail=${detail} .line=${line} .online=${online}></t-part-weather>`;
    case "camera":
      return html`<t-part-camera .site=${site} .device=${device} .detail=${detail} .line=${line} .online=${online}></t-part-camera>`;
    case "power":
      return html`<t-part-power .site=${site} .device=${device} .detail=${detail} .line=${line} .online=${online}></t-part-power>`;
    case "pictures":
    case "none":
      return nothing;
  }
}
