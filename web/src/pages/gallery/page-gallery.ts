/** Every element in every state, to look at and to test against. */

import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { base, panelBox, quietText } from "../../elements/base/base-style.js";
import type { GalleryEntry } from "./entry.js";

const files = import.meta.glob<{ entries: readonly GalleryEntry[] }>("./entries*.ts", { eager: true });
const all = Object.values(files).flatMap((file) => file.entries);

@customElement("t-page-gallery")
export class PageGallery extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        gap: var(--t-space-5);
      }
      section {
        display: grid;
        gap: var(--t-space-3);
      }
      .states {
        display: grid;
        grid-template-columns: repeat(auto-fill, minmax(min(15rem, 100%), 1fr));
        gap: var(--t-space-3);
      }
      .wide {
        grid-template-columns: 1fr;
      }
      figure {
        display: grid;
        /* What is wider than a phone scrolls inside it, as on its own page. */
        grid-template-columns: minmax(0, 1fr);
        align-content: space-between;
        gap: var(--t-space-3);
        margin: 0;
        padding: var(--t-space-4);
        ${panelBox}
        min-inline-size: 0;
      }
      figcaption {
        ${quietText}
      }
      h2 {
        font-family: var(--t-mono);
        font-size: var(--t-size-m);
      }
    `,
  ];

  override render(): TemplateResult {
    return html`
      <h1>Gallery</h1>
      ${map(
        all,
        (entry) => html`<section id=${entry.tag}>
          <h2>${entry.tag}</h2>
          <div class=${entry.wide === true ? "states wide" : "states"}>
            ${map(
              entry.states,
              (state) => html`<figure><div>${state.show()}</div><figcaption>${state.name}</figcaption></figure>`,
            )}
          </div>
        </section>`,
      )}
    `;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-gallery": PageGallery;
  }
}
