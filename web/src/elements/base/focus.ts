/** Where the focus goes when a form opens or closes: whoever came by keyboard goes on from there. */

import { LitElement } from "lit";

/** Focuses what an element is about to draw; nothing where it does not. */
export async function focusInside(host: LitElement, selector: string): Promise<void> {
  await host.updateComplete;
  const found = host.renderRoot.querySelector<HTMLElement>(selector);
  // Before that a field has no name, and a button of ours no button in it.
  const around = found?.closest("t-field, t-button");
  if (around instanceof LitElement) await around.updateComplete;
  found?.focus();
}
