/** A form that says what a page shows: what is chosen counts at once, what is typed when it rests. */

import type { ReactiveController, ReactiveControllerHost } from "lit";

const TYPING_MS = 400;

type FilterFormHost = ReactiveControllerHost & { readonly renderRoot: ParentNode };

export class FilterForm<F> implements ReactiveController {
  private timer: ReturnType<typeof setTimeout> | undefined;

  /**
   * @param read makes a filter of what stands in the form
   * @param go shows what a filter says
   * @param none the filter that lets everything through
   */
  constructor(
    private readonly host: FilterFormHost,
    private readonly read: (said: FormData) => F,
    private readonly go: (filter: F) => void,
    private readonly none: F,
  ) {
    host.addController(this);
  }

  hostDisconnected(): void {
    clearTimeout(this.timer);
  }

  /** For the form's `input`. */
  readonly onInput = (event: Event): void => {
    const form = event.currentTarget;
    if (!(form instanceof HTMLFormElement)) return;
    const typing = event.target instanceof HTMLInputElement && event.target.type !== "checkbox";
    clearTimeout(this.timer);
    this.timer = setTimeout(
      () => {
        this.go(this.read(new FormData(form)));
      },
      typing ? TYPING_MS : 0,
    );
  };

  /** For the form's `submit`, and for `change` where nothing is shown while it is typed. */
  readonly onSubmit = (event: Event): void => {
    event.preventDefault();
    clearTimeout(this.timer);
    if (event.currentTarget instanceof HTMLFormElement) this.go(this.read(new FormData(event.currentTarget)));
  };

  /** For a button that shows everything. */
  readonly clearFilter = (event: UIEvent): void => {
    clearTimeout(this.timer);
    const form = this.host.renderRoot.querySelector("form");
    form?.reset();
    this.go(this.none);
    // Pressed by a key, it takes the focus with it: it is disabled now, or gone.
    if (event.detail === 0) form?.querySelector<HTMLElement>("input, select")?.focus();
  };
}
