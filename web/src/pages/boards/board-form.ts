/** What a board is called, and whom it serves: one site or any, devices of one kind or all. */

import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { base } from "../../elements/base/base-style.js";
import { renderOptions } from "../../elements/forms/form-parts.js";
import { control } from "../../elements/forms/input-style.js";
import { deviceKindWords } from "../../format/kinds/device-kinds.js";
import type { BoardShape, SiteShape } from "../../generated/api.js";
import "../../elements/forms/field.js";

/** @fires t-board what of the board is changed; detail is that part of it */
@customElement("t-board-form")
export class BoardForm extends LitElement {
  static override styles = [
    base,
    control,
    css`
      :host {
        display: contents;
      }
    `,
  ];

  @property({ attribute: false }) board: BoardShape | null = null;
  @property({ attribute: false }) detail: SiteShape | null = null;

  override render(): TemplateResult | typeof nothing {
    const { board, detail } = this;
    if (board === null || detail === null) return nothing;
    const kinds = [...new Set([...detail.devices.map(({ kind }) => kind), ...(board.kind === "" ? [] : [board.kind])])];
    return html`<t-field label=${msg("Name")}><input name="name" type="text" maxlength="100" .value=${board.name} @input=${this.onName} /></t-field>
      <t-field label=${msg("Site")}><select name="site" @change=${this.onSite}>${renderOptions([[detail.site, detail.name], ["", msg("any site")]], board.site)}</select></t-field>
      <t-field label=${msg("Kind of device")}><select name="kind" @change=${this.onKind}>${renderOptions([["", msg("any kind")], ...kinds.map((kind) => [kind, deviceKindWords(kind)] as const)], board.kind)}</select></t-field>`;
  }

  private readonly onName = (event: Event): void => {
    if (event.target instanceof HTMLInputElement) this.fire({ name: event.target.value });
  };

  private readonly onSite = (event: Event): void => {
    if (event.target instanceof HTMLSelectElement) this.fire({ site: event.target.value });
  };

  private readonly onKind = (event: Event): void => {
    const { board, detail } = this;
    if (!(event.target instanceof HTMLSelectElement) || board === null) return;
    const kind = detail?.devices.find((device) => device.kind === (event.target as HTMLSelectElement).value)?.kind ?? "";
    // It begins with the device that it had, if that is of the kind.
    const own = detail?.devices.find(({ id }) => id === board.device);
    this.fire({ kind, device: kind === "" || own?.kind === kind ? board.device : "" });
  };

  private fire(change: Partial<BoardShape>): void {
    this.dispatchEvent(new CustomEvent("t-board", { detail: change }));
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-board-form": BoardForm;
  }
}
