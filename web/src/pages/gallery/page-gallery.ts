/**
 * Every element in every state, to look at and to test against. `?tile=chart` shows one of the tiles of boards in its
 * states in the place of the elements: together they would be hundreds of maps, scenes and charts.
 */

import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { repeat } from "lit/directives/repeat.js";
import { base, panelBox, quietText } from "../../elements/base/base-style.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { routerContext } from "../../state/contexts.js";
import { styled } from "../../elements/base/style-directive.js";
import type { GalleryEntry } from "./entry.js";
import { TILE_SECTIONS } from "./tile-states.js";

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
      .sized {
        grid-template-columns: repeat(auto-fill, minmax(min(var(--least), 100%), 1fr));
      }
      nav {
        display: flex;
        flex-wrap: wrap;
        gap: 0 var(--t-space-4);
      }
      nav a {
        display: inline-flex;
        align-items: center;
        min-block-size: 1.75rem;
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

  constructor() {
    super();
    // Another section is another address of the same page.
    new ContextStoreController(this, routerContext);
  }

  override render(): TemplateResult {
    const tile = new URLSearchParams(location.search).get("tile") ?? "";
    const chosen = TILE_SECTIONS.get(tile);
    return html`
      <h1>Gallery</h1>
      <nav aria-label="Sections of the gallery">
        <a href="/gallery" aria-current=${chosen === undefined ? "page" : nothing}>Elements</a>
        ${map(TILE_SECTIONS, ([type, { title }]) => html`<a href=${`/gallery?tile=${type}`} aria-current=${type === tile ? "page" : nothing}>${title}</a>`)}
      </nav>
      ${repeat(chosen === undefined ? all : [chosen], ({ tag }) => tag, renderSection)}
    `;
  }
}

function renderSection({ tag, title, states, wide, least }: GalleryEntry): TemplateResult {
  const look = least === undefined ? (wide === true ? "states wide" : "states") : "states sized";
  return html`<section id=${tag}>
    <h2>${title ?? tag}</h2>
    <div class=${look} ${styled({ "--least": `${String(least ?? 15)}rem` })}>
      ${map(states, (state) => html`<figure><div>${state.show()}</div><figcaption>${state.name}</figcaption></figure>`)}
    </div>
  </section>`;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-gallery": PageGallery;
  }
}
