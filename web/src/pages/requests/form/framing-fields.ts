/** Part of the form: the framing of a target among the stars, once somebody opens it. */

import { msg } from "@lit/localize";
import { html, nothing, type TemplateResult } from "lit";
import type { RequestShape } from "../../../generated/api.js";
import type { SkyFrame } from "../../../elements/observatory/framing-view.js";
import { MOST_REQUESTS } from "./draft.js";
import type { DraftEditor } from "./draft-editor.js";
import type { FormView } from "./form-view.js";
import "./framing-panel.js";

/**
 * @param site whose hub has the stars
 * @param isOpen whether it is drawn, and asks for them
 */
export function renderFraming(view: FormView, editor: DraftEditor, site: string, isOpen: boolean, onToggle: (event: Event) => void): TemplateResult | typeof nothing {
  const { request, readRequest, read, at, abilities } = view;
  if (request.way !== "stars") return nothing;
  const { target } = readRequest;
  const described = abilities?.field ?? null;
  const frames = read.requests.map((other) => frameOf(other.target, described?.position_angle ?? 0));
  const others = frames.filter((frame, i): frame is SkyFrame => i !== at && frame !== null);
  const onMoved = (event: HTMLElementEventMap["t-frame-moved"]): void => {
    editor.moveTarget(event.detail.centre);
  };
  const onTurned = (event: HTMLElementEventMap["t-frame-turned"]): void => {
    editor.changeRequest({ angle: event.detail });
  };
  const onPanels = (event: HTMLElementEventMap["t-panels"]): void => {
    editor.makePanels(event.detail, described?.rotates === true);
  };
  return html`<fieldset>
    <legend>${msg("Framing")}</legend>
    <details class="wide" ?open=${isOpen} @toggle=${onToggle}>
      <summary>${msg("What the camera shows, and mosaics")}</summary>
      ${isOpen
        ? html`<t-framing-panel
            .site=${site}
            .centre=${frames[at]?.centre ?? null}
            .name=${request.target.trim()}
            .angle=${request.angle}
            .angleProblem=${readRequest.problems.get("angle") ?? ""}
            .angleDeg=${target?.type === "ICRS" ? (target.position_angle ?? null) : null}
            .described=${described}
            .others=${others}
            .shutterS=${readRequest.shutterS}
            .room=${MOST_REQUESTS - read.requests.length + 1}
            .made=${editor.beforePanels !== null}
            @t-frame-moved=${onMoved}
            @t-frame-turned=${onTurned}
            @t-panels=${onPanels}
            @t-panels-undone=${editor.undoPanels}
          ></t-framing-panel>`
        : nothing}
    </details>
  </fieldset>`;
}

/** @param stands the angle at which the camera stands by itself (°) */
function frameOf(target: RequestShape["target"], stands: number): SkyFrame | null {
  return target?.type === "ICRS" ? { centre: { raDeg: target.ra, decDeg: target.dec }, angle: target.position_angle ?? stands } : null;
}
