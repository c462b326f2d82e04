/** What was done to a text, so that it can be taken back and done again. */

const MOST = 200;

export class EditHistory {
  private before: string[] = [];
  private after: string[] = [];

  constructor(private current: string) {}

  get text(): string {
    return this.current;
  }

  get canUndo(): boolean {
    return this.before.length > 0;
  }

  get canRedo(): boolean {
    return this.after.length > 0;
  }

  /**
   * Takes another text.
   *
   * @param along it goes on with the last one, as typing does: one step back undoes both
   */
  recordEdit(text: string, along = false): void {
    if (text === this.current) return;
    if (!along || this.before.length === 0) {
      this.before = [...this.before.slice(1 - MOST), this.current];
    }
    this.current = text;
    this.after = [];
  }

  undoEdit(): void {
    const text = this.before.pop();
    if (text === undefined) return;
    this.after.push(this.current);
    this.current = text;
  }

  redoEdit(): void {
    const text = this.after.pop();
    if (text === undefined) return;
    this.before.push(this.current);
    this.current = text;
  }
}
