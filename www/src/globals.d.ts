/** The folders of what finds faces and people, relative to the page: see mediapipe.js. */
declare const __MEDIAPIPE__: { readonly faces: string; readonly person: string };

interface Window {
  /** For automation. */
  designer: {
    readonly model: import('phiz').FaceModel;
    /** The face on the page. Whoever changes it must not expect the page to notice. */
    readonly face: import('phiz').Face;
    /** The colours of skin, lips, brows and eyes that are not the model's own. */
    readonly colouring: import('./head/colouring.js').Colouring;
    /** Frames drawn so far: an idle page draws none. */
    readonly frames: number;
    /** Whether the picture has come to rest, with smooth edges. */
    readonly isFine: boolean;
    /** Whether pictures that rest are refined, which takes the time of some more: on, until who takes many asks otherwise. */
    refine(wanted: boolean): void;
    /** Where a landmark is on the screen, CSS pixels. */
    onScreen(landmark: string): { x: number; y: number };
    /** The photo that is worked on, its points and its fit; null before the section for photos was opened. */
    readonly photo: ReturnType<typeof import('./photo/room.js').createRoom>['state'] | null;
  };
}
