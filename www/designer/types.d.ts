// The types of phiz-designer.js, beside which the built site has them as phiz-designer.d.ts.

import type { Face, FaceModel } from 'phiz';

export interface PhizDesignerEventMap {
  face: CustomEvent<{ code: string }>;
  ready: CustomEvent<{ code: string }>;
  input: CustomEvent<{ code: string }>;
  change: CustomEvent<{ code: string }>;
  error: CustomEvent<{ message: string }>;
}

type Colour =
  | 'skin' | 'blood' | 'lips' | 'lines' | 'freckles'
  | 'hair' | 'red' | 'grey' | 'iris'
  | 'brows' | 'browBreadth' | 'browArch' | 'browSlant' | 'browApart' | 'browRaise' | 'browShade' | 'browGrey'
  | 'crop' | 'hairline' | 'length' | 'comb' | 'parting' | 'curl' | 'thin'
  | 'beard' | 'beardLength' | 'beardThin' | 'moustache' | 'chinBeard' | 'cheekBeard' | 'beardShade' | 'beardRed' | 'beardGrey'
  | 'glasses' | 'lensForm' | 'lensSize' | 'lensHeight' | 'lensSweep' | 'rim' | 'halfRim' | 'noseBar' | 'frameColour' | 'tint';

/** Numbers from 0 to 1, and the marks of the skin as a link of the page has them. */
export type PhizColours = { readonly [name in Colour]?: number } & { readonly marks?: string };

/** What the element has beside others' members; what each does is told in README.md. */
export interface PhizDesignerMembers {
  readonly model: FaceModel | null;
  readonly face: Face | null;
  get src(): string;
  set src(src: string | null | undefined);
  get head(): string;
  set head(head: string | null | undefined);
  get controls(): string | null;
  set controls(controls: string | null | undefined);
  get theme(): string;
  set theme(theme: string | null | undefined);
  get code(): string;
  set code(code: string | null | undefined);
  get colours(): PhizColours;
  set colours(colours: PhizColours | Readonly<Record<string, number | string | undefined>> | string | null | undefined);
  set(control: string, value: number): void;
  get(control: string): number;
  reset(region?: string): void;
  randomize(options?: Parameters<Face['randomize']>[0]): number;
  view(name: 'front' | 'quarter' | 'profile'): void;
  toPng(options?: { width?: number | undefined; height?: number | undefined; transparent?: boolean | undefined }): Promise<Blob>;
  toMesh(format: 'glb' | 'obj' | 'ply' | 'stl', options?: { targets?: boolean | undefined }): Promise<Uint8Array<ArrayBuffer>>;
  refresh(): void;
}

/** Its own in place of others' of that name. */
type EventMap = Omit<HTMLElementEventMap, keyof PhizDesignerEventMap> & PhizDesignerEventMap;

/** `<phiz-designer>` */
export interface PhizDesignerElement extends HTMLElement, PhizDesignerMembers {
  addEventListener<K extends keyof EventMap>(
    type: K,
    listener: (this: PhizDesignerElement, event: EventMap[K]) => unknown,
    options?: boolean | AddEventListenerOptions,
  ): void;
  addEventListener(type: string, listener: EventListenerOrEventListenerObject | null, options?: boolean | AddEventListenerOptions): void;
  removeEventListener<K extends keyof EventMap>(
    type: K,
    listener: (this: PhizDesignerElement, event: EventMap[K]) => unknown,
    options?: boolean | EventListenerOptions,
  ): void;
  removeEventListener(type: string, listener: EventListenerOrEventListenerObject | null, options?: boolean | EventListenerOptions): void;
}

export const PhizDesigner: { new (): PhizDesignerElement; prototype: PhizDesignerElement };

declare global {
  interface HTMLElementTagNameMap {
    'phiz-designer': PhizDesignerElement;
  }
}
